"""Suites of scenarios: their TOML files and what reads them."""
