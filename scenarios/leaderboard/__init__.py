"""Leaderboard: its plans, tuning, page, and the growth of times."""
