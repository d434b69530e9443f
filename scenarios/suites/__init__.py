"""Suites of scenarios: TOML files and their readers."""
