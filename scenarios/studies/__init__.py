"""The pages under results/."""
