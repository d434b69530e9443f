"""Proposal of placements: by pairs of rectangles, by every shift, and near a given placement."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.robust.correlation import correlate, scales_within
from rectmerge.robust.correlation_params import CorrelateParams
from rectmerge.robust.directions import meeting_turns
from rectmerge.robust.features import QUARTER_TURN_DEG, Frame
from rectmerge.robust.hypotheses import propose
from rectmerge.robust.likelihood import WallLikelihood, WallNoise
from rectmerge.robust.working_pair import WorkingPair


def propose_by_rectangles(
    pair: WorkingPair, frames_a: Sequence[Frame], frames_b: Sequence[Frame]
) -> NDArray[np.float64]:
    """Refine the best of the placements that pairs of rectangles propose, shape (N, 4)."""
    hypotheses = propose(frames_a, frames_b, pair.scale_bounds, pair.params.propose)
    return propose_near(pair, hypotheses) if len(hypotheses) else np.empty((0, 4))


def propose_by_correlation(
    pair: WorkingPair, angles_a: Sequence[float], angles_b: Sequence[float]
) -> NDArray[np.float64]:
    """Refine the best of all shifts, at every scale, that lay a direction of B on one of A, shape (N, 4)."""
    params = pair.params.correlate
    if not pair.params.propose.use_correlation:
        return np.empty((0, 4))
    faces_b = [pair.b.faces(angle, pair.params.faces) for angle in angles_b]
    frames = [(pair.a.faces(angle, pair.params.faces), faces_b) for angle in angles_a]
    scales = scales_within(pair.scale_bounds, params.scale_step)
    return _best_shifts(pair, frames, scales, params.shifts_per_scale, params.max_correlation_fits)


def propose_all_round(
    pair: WorkingPair, energies_a: NDArray[np.float64], energies_b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Refine the best of all shifts at angles all round at which walls can meet, on coarse grids, shape (N, 4).

    Directions in which walls pile up say nothing in round buildings, and in buildings of several wings those of one map
    may be of another wing than those of the other.
    """
    params = pair.params.all_round
    coarse = replace(
        pair.params.correlate,
        cell_cells=params.cell_cells,
        max_diagonal_cells=params.max_diagonal_cells,
        spread_cells=params.spread_cells,
    )
    turns = np.radians(np.arange(params.turn_step_deg, QUARTER_TURN_DEG, params.turn_step_deg))
    between = pair.angle - pair.angle_b  # of the strongest directions, which were tried before
    turns = meeting_turns(energies_a, energies_b, between + turns, params)
    if len(turns) == 0:
        return np.empty((0, 4))
    frames = [(pair.a.faces(pair.angle, pair.params.faces), [pair.faces_of_b(float(turn)) for turn in turns])]
    scales = scales_within(pair.scale_bounds, params.scale_step)
    return _best_shifts(pair, frames, scales, params.shifts_per_scale, params.max_fits, coarse)


def propose_rivals(pair: WorkingPair, placement: NDArray[np.float64]) -> NDArray[np.float64]:
    """Refine the best of all shifts and quarter turns of a placement, at its scale, shape (N, 4)."""
    params = pair.params.correlate
    if not pair.params.propose.use_rivals:
        return np.empty((0, 4))
    turn, scale = math.atan2(placement[1], placement[0]), math.hypot(placement[0], placement[1])
    frames = [(pair.a.faces(pair.angle, pair.params.faces), [pair.faces_of_b(turn)])]
    return _best_shifts(pair, frames, np.array([scale]), params.rival_shifts, params.max_rival_fits)


def propose_near(pair: WorkingPair, starts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Refine the best of some placements, shape (N, 4)."""
    params = pair.params.propose
    likelihood = pair.likelihood(WallNoise(params.noise_spreads_cells, params.noise_outliers))
    return _refined(pair, likelihood, _screened(pair, likelihood, starts))


def _screened(pair: WorkingPair, likelihood: WallLikelihood, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Keep the distinct hypotheses under which a sample of the walls agrees best."""
    params = pair.params.propose
    for round_, points in enumerate(params.screen_points):
        max_kept = len(hypotheses) if round_ else params.max_screened
        hypotheses = _best(hypotheses, likelihood.score(hypotheses, most_points=points), max_kept)
    return hypotheses[pair.distinct(hypotheses, params.same_hypothesis_cells, params.max_refined)]


def _refined(pair: WorkingPair, likelihood: WallLikelihood, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Refine the hypotheses, half of them all the way, and keep the best, distinct ones."""
    params = pair.params.propose
    fits = pair.fit(hypotheses, params.refine_points, params.coarse_reaches_cells)
    fits = _best(fits, likelihood.score(fits), len(fits) // 2 + 1)
    fits = pair.fit(fits, params.refine_points, params.fine_reaches_cells)
    fits = _best(fits, likelihood.score(fits), len(fits))
    return fits[pair.distinct(fits, params.same_fit_cells, params.max_fits)]


def _best_shifts(
    pair: WorkingPair,
    frames: Sequence[tuple[WallFaces, Sequence[WallFaces]]],
    scales: NDArray[np.float64],
    max_shifts: int,
    max_fits: int,
    params: CorrelateParams | None = None,
) -> NDArray[np.float64]:
    """Correlate maps in pairs of frames, and refine the best, distinct placements."""
    params, propose_params = params or pair.params.correlate, pair.params.propose
    peaks = [correlate(on_a, on_b, scales, params, pair.params.gain, max_shifts=max_shifts) for on_a, on_b in frames]
    placements, gains = (np.concatenate(parts) for parts in zip(*peaks, strict=True))
    placements = _best(placements, gains, len(gains))
    best = placements[pair.distinct(placements, propose_params.same_hypothesis_cells, max_fits)]
    return pair.fit(best, propose_params.refine_points, params.reaches_cells)


def _best(placements: NDArray[np.float64], scores: NDArray[np.floating], max_kept: int) -> NDArray[np.float64]:
    """Order placements by score, best first, and keep the first ones."""
    best: NDArray[np.float64] = placements[np.argsort(-scores, kind="stable")[:max_kept]]
    return best
