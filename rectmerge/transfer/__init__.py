"""Transforms and points carried from map B to map A."""
