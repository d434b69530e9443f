"""Judge of other methods' answers: what the walls say of a placement decides whether a map is written."""

from __future__ import annotations

import dataclasses

import numpy as np

from rectmerge.aligning import Scale, check, judges_itself
from rectmerge.alignment import Alignment, Method
from rectmerge.analysis.displacement import displacement_cells
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import DEFAULT_METHOD

SAME_SHARE = 0.01  # of the extent of A's known cells: a placement is right within that, as the benchmark scores it
SAME_CELLS = 2.0  # and within that at least


def confirm(
    a: OccupancyGrid, b: OccupancyGrid, alignment: Alignment, *, method: Method, scale: Scale = "auto", seed: int = 0
) -> Alignment:
    """Put a method's answer to the judge of `check`, and return it with the verdict to act on.

    Parameters
    ----------
    a, b
        The two maps.
    alignment
        The answer of `method` to them.
    method, scale, seed
        As the answer was asked for.

    Returns
    -------
    Alignment
        The answer itself where the method accepts nothing, or is a judge itself. Else its candidates with the judge's
        verdict on the first as `verdict` and `checked`, the judge's confidence in it, and the method's own verdict as
        `method_verdict`. It is accepted where the judge accepts a placement that is the same within 1 % of A's extent.
    """
    if not alignment or judges_itself(method):
        return alignment
    placement = alignment.candidates[0].pixels
    try:
        judged = check(a, b, placement, scale=scale, seed=seed)
    except InputError as error:  # a placement that nobody could mean
        judged = Alignment(verdict="rejected", reason=str(error), method=DEFAULT_METHOD)
    verdict, reason, confidence = judged.verdict, judged.reason, judged.confidence
    if judged:
        moved = displacement_cells(b, placement, judged.candidates[0].pixels)
        if moved > max(SAME_CELLS, SAME_SHARE * _extent_cells(a)):
            verdict, reason = "rejected", f"the walls fit {moved:.1f} cells beside its placement, not on it"
            confidence = 1 - confidence  # that the placement beside it is wrong
    best, *others = alignment.candidates
    return dataclasses.replace(
        alignment,
        verdict=verdict,
        method_verdict=alignment.verdict,
        checked=verdict,
        reason=f"{method.name} says {alignment.verdict}, {alignment.reason}; the check says {verdict}, {reason}",
        candidates=(dataclasses.replace(best, confidence=confidence), *others),
        confidence=confidence,
    )


def _extent_cells(grid: OccupancyGrid) -> float:
    """Return the diagonal of the bounding box of a map's known cells."""
    rows, cols = (np.flatnonzero((~grid.unknown).any(axis=axis)) for axis in (1, 0))
    return float(np.hypot(rows[-1] - rows[0] + 1, cols[-1] - cols[0] + 1))
