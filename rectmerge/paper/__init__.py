"""The paper's method, one file per algorithm."""
