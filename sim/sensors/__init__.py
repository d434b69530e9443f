"""Laser scanners and ray casting."""
