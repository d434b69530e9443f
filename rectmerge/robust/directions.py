"""Directions of one map's walls, modulo a quarter turn, and the turns at which those of two maps meet."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.profiles import profile_energies
from rectmerge.robust.correlation_params import AllRoundParams
from rectmerge.robust.features import QUARTER_TURN_DEG, Features
from rectmerge.robust.params import PrepareParams


def direction_energies(features: Features, params: PrepareParams) -> NDArray[np.float64]:
    """Measure how much the walls pile up along each whole degree of a quarter turn, shape (90,)."""
    points = _centred(features)
    some = points[:: -(-len(points) // params.max_projected_points)]
    return _folded_energy(some, np.radians(np.arange(float(QUARTER_TURN_DEG))), params.coarse_bin_cells)


def dominant_angles(features: Features, params: PrepareParams) -> list[tuple[float, float]]:
    """Find the directions along which walls pile up, modulo a quarter turn.

    Returns
    -------
    list
        (angle, contrast), strongest first: radians in the working grid, and the peak's energy above the median over the
        median. Weaker peaks than a share of the first are left out; the first is always there.
    """
    points, degrees = _centred(features), np.arange(QUARTER_TURN_DEG)
    energy = direction_energies(features, params)
    floor = float(np.median(energy))
    left = energy - floor
    peaks: list[tuple[float, float]] = []
    while not peaks or (len(peaks) < params.max_directions and left.max() > 0):
        at = int(np.argmax(left))
        if peaks and left[at] < params.min_direction_share * floor * peaks[0][1]:
            break
        angle = math.radians(at)
        steps = np.arange(-params.fine_reach_steps, params.fine_reach_steps + 1.0)
        for step in params.fine_steps_deg:
            near: NDArray[np.float64] = angle + math.radians(step) * steps
            angle = float(near[np.argmax(_folded_energy(points, near, params.fine_bin_cells))])
        peaks.append((angle, float(left[at]) / floor))
        left[np.abs((degrees - at + 45) % 90 - 45) <= params.direction_width_deg] = 0
    return peaks


def meeting_turns(
    energies_a: NDArray[np.float64],
    energies_b: NDArray[np.float64],
    turns: NDArray[np.float64],
    params: AllRoundParams,
) -> NDArray[np.float64]:
    """Keep the turns of B, radians, that lay directions in which its walls pile up on such directions of A's.

    Where the walls of one map pile up nowhere, as in round buildings, no turn is ruled out.
    """
    (share_a, contrast_a), (share_b, contrast_b) = (
        _direction_shares(energies_a, params),
        _direction_shares(energies_b, params),
    )
    if min(contrast_a, contrast_b) < params.weak_contrast:
        return turns
    common = np.array([np.minimum(share_a, np.roll(share_b, turn)).sum() for turn in range(QUARTER_TURN_DEG)])
    met = common[np.rint(np.degrees(turns)).astype(int) % QUARTER_TURN_DEG]
    kept: NDArray[np.float64] = turns[met >= params.min_meeting_share * common.max()]
    return kept


def _direction_shares(energies: NDArray[np.float64], params: AllRoundParams) -> tuple[NDArray[np.float64], float]:
    """Return the shares of the energy above the median, smoothed, shape (90,), and its peak over the median."""
    floor = float(np.median(energies))
    excess = np.maximum(energies - floor, 0.0)
    window = np.bartlett(2 * params.meeting_reach_deg + 1)
    smooth = np.convolve(np.pad(excess, params.meeting_reach_deg, mode="wrap"), window, mode="valid")
    return smooth / max(float(smooth.sum()), np.finfo(float).tiny), float(excess.max()) / floor


def _centred(features: Features) -> NDArray[np.float64]:
    """Return the wall points about their centroid."""
    points: NDArray[np.float64] = features.walls - features.walls.mean(axis=0)
    return points


def _folded_energy(points: NDArray[np.float64], angles: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """Sum the energies of the profiles on both axes of each frame."""
    both = profile_energies(points, np.concatenate([angles, angles + math.pi / 2]), width)
    folded: NDArray[np.float64] = both.reshape(2, -1).sum(axis=0)
    return folded
