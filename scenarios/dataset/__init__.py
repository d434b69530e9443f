"""Data sets on disk: generated, read, verified."""
