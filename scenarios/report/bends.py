"""Bends of each method's accepted answers: counts, errors and double walls before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scenarios.scoring.bends import BendTally
from scenarios.scoring.row import Row


def bend_cells(rows: Mapping[str, Sequence[Row]]) -> list[tuple[str, list[str]]]:
    """Return the cells of each method's line; no line where no method's map was bent."""
    lines = []
    for label, answers in rows.items():
        tally = BendTally()
        for row in answers:
            tally.add(row)
        lines.append((label, tally))
    if not any(tally.accepted for _, tally in lines):
        return []
    return [(label, _cells(tally.summary())) for label, tally in lines if tally.tried]


def _cells(summary: Mapping[str, Any]) -> list[str]:
    errors, walls = (
        [summary[f"{name}_{when}"] for when in ("before", "after")] for name in ("median_e_px", "mean_double_walls")
    )
    return [
        *(str(summary[name]) for name in ("tried", "accepted")),
        *("-" if error is None else f"{error:.2f}" for error in errors),
        *(str(summary[name]) for name in ("better", "worse")),
        *("-" if share is None else f"{share:.0%}" for share in walls),
    ]
