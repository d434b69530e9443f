"""Bends of accepted answers: a row's values, and their sums over rows."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import Any, TypedDict

import numpy as np

CHANGE = 0.1  # of the error, from which a bend counts as better or worse


class BendValues(TypedDict):
    """Bend that `merge` would try on an accepted answer.

    `e_px` is the RMSE over the control points once B is bent, in cells of A: where the bend is refused, that of the
    placement; None without truth. `double_walls` are shares of the common walls that the merged map shows twice.
    """

    accepted: bool
    reason: str
    e_px: float | None
    double_walls_before: float | None
    double_walls_after: float | None


class BendTally:
    """Running totals of bends: counts, and a few numbers of each that is accepted."""

    def __init__(self) -> None:
        self.tried = self.accepted = self.better = self.worse = 0
        self._errors = array("d"), array("d")  # before, after
        self._double_walls = array("d"), array("d")

    def add(self, row: Mapping[str, Any]) -> None:
        """Add a row; rows without a bend, those of earlier versions too, change nothing."""
        bend: BendValues | None = row.get("bend")
        if bend is None:
            return
        self.tried += 1
        if not bend["accepted"]:
            return
        self.accepted += 1
        walls = bend["double_walls_before"], bend["double_walls_after"]
        if None not in walls:
            _append(self._double_walls, *walls)
        if row["errors"] and bend["e_px"] is not None:
            before, after = float(row["errors"]["e_px"]), bend["e_px"]
            self.better += after < (1 - CHANGE) * before
            self.worse += after > (1 + CHANGE) * before
            _append(self._errors, before, after)

    def summary(self) -> dict[str, Any]:
        """Return counts and, of the accepted bends, medians of the error and means of the double walls."""
        before, after = (float(np.median(part)) if part else None for part in self._errors)
        walls_before, walls_after = (float(np.mean(part)) if part else None for part in self._double_walls)
        return {
            "tried": self.tried,
            "accepted": self.accepted,
            "better": self.better,
            "worse": self.worse,
            "median_e_px_before": before,
            "median_e_px_after": after,
            "mean_double_walls_before": walls_before,
            "mean_double_walls_after": walls_after,
        }


def _append(arrays: tuple[array[float], array[float]], *values: float | None) -> None:
    for part, value in zip(arrays, values, strict=True):
        part.append(float(value or 0.0))
