"""Pairs of maps and their ground truth."""
