"""Finished runs as one page to show: leaderboard, charts, and every pair to look at."""
