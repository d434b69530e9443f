"""Baselines: the methods in common use, each written from its article, behind the protocol of all methods."""
