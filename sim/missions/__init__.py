"""Missions of two robots and their logs."""
