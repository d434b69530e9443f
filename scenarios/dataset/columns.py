"""The columns of a data set's rows: every row gets the same keys, and every key one type."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


class Columns:
    """Types of a data set's columns, learnt from all rows.

    Readers such as `datasets` take a column's type from a split's first rows, and want the same in every split. First
    stand the related pairs: what all of these tell has its type, and is null where an unrelated pair does not tell it.
    Any other key becomes text, empty where there is nothing to tell, as does one whose values are of several kinds.
    Numbers become floats where some are, and an empty list tells nothing.
    """

    def __init__(self) -> None:
        self._kinds: dict[str, set[type]] = {}
        self._told: dict[bool, dict[str, int]] = {True: {}, False: {}}  # by whether the pairs are related
        self._rows = {True: 0, False: 0}

    def note(self, row: Mapping[str, Any]) -> None:
        """Learn from a row."""
        is_related = bool(row["related"])
        self._rows[is_related] += 1
        for key, value in row.items():
            kinds, told = self._kinds.setdefault(key, set()), self._told[is_related]
            if value is not None and value != []:
                kinds.add(type(value))
                told[key] = told.get(key, 0) + 1

    def fitted(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return a row with every key, each of its column's type."""
        return {key: self._value(key, row.get(key)) for key in self._kinds}

    def _value(self, key: str, value: Any) -> Any:
        kinds, leading = self._kinds[key], self._rows[True] > 0
        has_type = self._told[leading].get(key, 0) == self._rows[leading] and (len(kinds) == 1 or kinds == {int, float})
        if value is None or value == []:
            return None if has_type or not kinds else ""
        if has_type:
            return float(value) if float in kinds else value
        return value if isinstance(value, str) else json.dumps(value)
