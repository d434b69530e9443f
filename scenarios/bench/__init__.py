"""Runs: methods put to pairs, and the rows that come of it."""
