"""Plausibility of a placement from the agreement of the walls: a logistic model of rigid maps, and one of bent maps.

The weights of both are what `rectbench calibrate` prints for the split train of the suites `trust` and `standard` and
for real maps; results/trust says what they are worth on places that took no part in the fit. The model of bent maps
counts for less where rigid maps explain the pair.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import Agreements

CONTRADICTIONS = ("on_floor", "beside", "corners_missed", "corners_denied")
RIGID_TERMS = (
    "one", "matched", "clutter_matched", "clutter_off", "log_clutter_matched", "violations", "log_overlap",
    *CONTRADICTIONS,
)  # fmt: skip
BENT_TERMS = ("one", "sqrt_iou", "log_support", "violations", "contradicted", "log_overlap", "surface_exact")


def rigid_terms(agreements: Agreements, params: ConfidenceParams) -> NDArray[np.float64]:
    """Return the terms of N placements in the model of rigid maps, shape (N, len(RIGID_TERMS))."""
    columns = (
        np.ones_like(agreements.matched),
        agreements.matched,
        agreements.clutter_matched,
        1.0 - agreements.clutter_matched - agreements.clutter_contradicted,
        np.log(agreements.clutter * agreements.clutter_matched + params.min_matched_faces),
        agreements.violations,
        np.log(agreements.overlap + params.min_overlap),
        *(getattr(agreements, name) for name in CONTRADICTIONS),
    )
    return np.stack(columns, axis=1)


def bent_terms(
    agreements: Agreements,
    support: NDArray[np.float64],
    surface_matched: NDArray[np.float64],
    params: ConfidenceParams,
) -> NDArray[np.float64]:
    """Return the terms of N placements in the model of bent maps, shape (N, len(BENT_TERMS)).

    Parameters
    ----------
    agreements
        Of N placements.
    support
        Shape (N,): damped log-likelihood ratio per wall point of the map that has fewer.
    surface_matched
        Shape (N,): share of the wall surface that meets exactly; see `surface_exact_odds`.
    params
        Parameters of the model.
    """
    columns = (
        np.ones_like(support),
        np.sqrt(agreements.iou),
        np.log(np.clip(support, 0.0, params.max_support) + params.min_support),
        agreements.violations,
        agreements.contradicted,
        np.log(agreements.overlap + params.min_overlap),
        np.maximum(0.0, surface_matched - params.bent_surface_matched),
    )
    return np.stack(columns, axis=1)


def rigid_odds(agreements: Agreements, params: ConfidenceParams) -> NDArray[np.float64]:
    """Return the log-odds that each of N placements is right, were there no other, if the maps are rigid, (N,)."""
    if not params.use_rigid:
        return np.full(len(agreements.matched), params.absent_log_odds)
    odds: NDArray[np.float64] = rigid_terms(agreements, params) @ np.array(params.rigid)
    return odds


def bent_odds(agreements: Agreements, support: NDArray[np.float64], params: ConfidenceParams) -> NDArray[np.float64]:
    """Return the same log-odds if the maps are bent, before `surface_exact_odds`."""
    if not params.use_bent:
        return np.full(len(support), params.absent_log_odds)
    odds: NDArray[np.float64] = bent_terms(agreements, support, np.zeros_like(support), params) @ np.array(params.bent)
    return odds


def surface_exact_odds(surface_matched: NDArray[np.float64], params: ConfidenceParams) -> NDArray[np.float64]:
    """Return what the exact fit adds to the log-odds of bent maps, shape (N,): 0 or below.

    Walls that meet exactly are not bent: where most of them do and the rest is contradicted, the maps are of two places
    with one shell, two storeys for example.

    Parameters
    ----------
    surface_matched
        Shape (N,): share of the wall surface on known cells of the other map that lies within two cells of that map's.
    params
        Parameters of the model.
    """
    odds: NDArray[np.float64] = params.bent[-1] * np.maximum(0.0, surface_matched - params.bent_surface_matched)
    return odds


def bent_handicap(thickness_cells: float, params: ConfidenceParams) -> float:
    """Return the log-odds by which maps are less likely bent, from the wall thickness of the fatter one; 0 or below.

    Where poses are wrong, walls are drawn again and again beside themselves: a map with crisp walls was made by good
    poses.
    """
    return params.thin_wall_cost * min(0.0, math.log(max(thickness_cells, 1.0) / params.fat_wall_cells))


def plausibility(rigid: NDArray[np.float64], bent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the log-odds of each of a pair's candidates, shape (N,).

    They are those of rigid maps, or of bent ones where no rigid one convinces: where none is right as rigid maps with a
    probability P, being right as bent maps counts P.
    """
    none_is_rigid = -np.logaddexp.reduce(np.append(rigid, 0.0))  # log P
    odds: NDArray[np.float64] = np.logaddexp(rigid, bent + none_is_rigid)
    return odds
