"""Page of finished runs: leaderboard, charts, and a gallery of every pair."""
