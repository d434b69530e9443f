"""Driving, coverage and exploration of robots."""
