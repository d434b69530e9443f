"""The plausibility of a placement from what speaks for it: two logistic models, one for rigid maps, one for bent ones.

`RIGID` was fitted by `rectbench calibrate` to simulated pairs, those of the split train of the suites `trust` (its seed
7000) and `standard`. `BENT` was fitted to hand-held maps of a few real
places, then changed by hand; it weighs less where rigid maps explain the pair.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.wall_agreement import WallAgreement

RIGID_TERMS = ("one", "matched", "clutter_matched", "clutter_off", "log_clutter_matched", "violations", "log_overlap")
RIGID = np.array([-4.28, 1.89, 6.44, -7.97, 1.00, -39.86, 2.74])
BENT = np.array([-8.0, 11.3, 10.0, -15.0, -80.0])  # of the columns of `bent_odds`
FAT_CELLS, THIN = 2.8, 5.0  # maps whose walls are thinner than this are less likely bent: log-odds per log thickness
LEAST_OVERLAP, FEWEST_MET, LARGEST_SUPPORT, MUCH_MISSING = 0.03, 20.0, 1.5, 0.1


def rigid_terms(weights: WallAgreement) -> NDArray[np.float64]:
    """Lay out what is weighed of N placements as rigid maps, shape (N, len(RIGID_TERMS))."""
    columns = (
        np.ones_like(weights.matched),
        weights.matched,
        weights.clutter_matched,
        1.0 - weights.clutter_matched - weights.clutter_contradicted,
        np.log(weights.clutter * weights.clutter_matched + FEWEST_MET),
        weights.violations,
        np.log(weights.overlap + LEAST_OVERLAP),
    )
    return np.stack(columns, axis=1)


def rigid_odds(weights: WallAgreement) -> NDArray[np.float64]:
    """Log-odds that each of N placements is right, were there no other, if the maps are rigid, shape (N,)."""
    odds: NDArray[np.float64] = rigid_terms(weights) @ RIGID
    return odds


def bent_odds(weights: WallAgreement, support: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same if the maps are bent.

    Parameters
    ----------
    weights
        Of N placements.
    support
        Shape (N,): damped log-likelihood ratio per wall point of the map that has fewer.
    """
    columns = (
        np.ones_like(support),
        np.sqrt(weights.iou),
        np.sqrt(np.clip(support, 0.0, LARGEST_SUPPORT)),
        weights.violations,
        np.maximum(0.0, weights.violations - MUCH_MISSING),
    )
    odds: NDArray[np.float64] = np.stack(columns, axis=1) @ BENT
    return odds


def bent_handicap(thickness_cells: float) -> float:
    """Log-odds by which maps are less likely bent if the walls of the fatter one are this thick; 0 if they are fat.

    Where poses are wrong, walls are drawn again and again beside themselves: a map with crisp walls was made by good
    poses.
    """
    return THIN * min(0.0, math.log(max(thickness_cells, 1.0) / FAT_CELLS))


def plausibility(rigid: NDArray[np.float64], bent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Log-odds of each of a pair's candidates, shape (N,): as rigid maps, or as bent ones where no rigid one convinces.

    Where none is right as rigid maps with a probability P, being right as bent maps counts P.
    """
    none_is_rigid = -np.logaddexp.reduce(np.append(rigid, 0.0))  # log P
    odds: NDArray[np.float64] = np.logaddexp(rigid, bent + none_is_rigid)
    return odds
