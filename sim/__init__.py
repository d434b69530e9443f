"""Simulated laser robots in indoor worlds: worlds, missions, and the maps that are built from their logs."""
