"""Demo, and the pictures under docs/."""
