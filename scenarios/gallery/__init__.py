"""The demo and the pictures under docs/."""
