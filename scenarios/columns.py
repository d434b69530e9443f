"""The columns of a data set's rows: every row gets the same keys, and every key one type."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

TRUTH = frozenset({"pixels", "control_points", "residual_px", "b_to_a", "overlap"})  # null where there is none


class Columns:
    """What the rows of a data set hold under each key, learnt from all of them.

    Readers such as `datasets` take a column's type from a split's first rows, and want the same in every split. So a
    key that some rows lack becomes text, empty where there is nothing to tell, as does one whose values are of several
    kinds; numbers become floats where some are. The truth is the exception: unrelated pairs have null.
    """

    def __init__(self) -> None:
        self._kinds: dict[str, set[type]] = {}
        self._filled: dict[str, int] = {}
        self._rows = 0

    def note(self, row: Mapping[str, Any]) -> None:
        """Learn from a row."""
        self._rows += 1
        for key, value in row.items():
            kinds = self._kinds.setdefault(key, set())
            if value is not None and value != []:
                kinds.add(type(value))
                self._filled[key] = self._filled.get(key, 0) + 1

    def fitted(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return a row with every key, each of its column's type."""
        return {key: self._value(key, row.get(key)) for key in self._kinds}

    def _value(self, key: str, value: Any) -> Any:
        kinds = self._kinds[key]
        if key in TRUTH:
            return value
        if kinds == {int, float} and self._filled[key] == self._rows:
            return float(value)
        if len(kinds) == 1 and self._filled[key] == self._rows:
            return value
        if value is None or value == []:
            return ""
        return value if isinstance(value, str) else json.dumps(value)
