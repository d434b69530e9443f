"""Studies of methods and data, and their pages under results/."""
