"""A pair of maps and its ground truth."""
