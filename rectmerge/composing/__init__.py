"""Composition of several aligned maps into one."""
