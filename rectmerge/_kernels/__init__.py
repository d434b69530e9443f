"""Compiled loops, one module per stage: arrays and numbers in, arrays and numbers out, no checks, no objects."""
