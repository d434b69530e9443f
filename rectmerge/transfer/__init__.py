"""Transforms, points and headings carried from map B to map A."""
