"""Marks of the cases of a test."""

from collections.abc import Iterable

import pytest


def some_slow(values: Iterable[object], *fast: object) -> list[object]:
    """Mark all values as slow but for those that stand for the others in `make test-fast`."""
    return [value if value in fast else pytest.param(value, marks=pytest.mark.slow) for value in values]
