"""Errors, outcomes and statistics."""
