"""Compiled loops of the simulation, one module per stage: arrays in, arrays out."""
