"""Placements of a component's maps from all agreeing pairs: iteratively reweighted linear least squares.

A similarity is linear in (a, b, tx, ty), in complex form in (turn, shift), so the placements that bring the shared
points of all pairs together solve a linear system. Weights are those of Geman and McClure (1987): a pair that
contradicts the others loses its say; at first only a little of it, so that the poses to begin with may be those of the
wrong pair (A. Blake and A. Zisserman, Visual Reconstruction, 1987, ch. 7). All maps' coordinates are taken about their
centre in units of their radius, which keeps the system well conditioned.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from rectmerge.fleet.complex_similarity import ComplexSimilarity, Points, rms
from rectmerge.fleet.cuts import reached
from rectmerge.fleet.evidence import PairCandidate
from rectmerge.fleet.map_sample import MapSample
from rectmerge.fleet.params import PlaceParams

NORMAL_MAD = 1.4826  # standard deviation over median absolute deviation, of a normal distribution


def place(
    maps: Sequence[MapSample],
    poses: Sequence[ComplexSimilarity],
    edges: Sequence[PairCandidate],
    held: Collection[int],
    params: PlaceParams,
) -> dict[int, ComplexSimilarity]:
    """Refine the poses of the maps that some pairs connect.

    Parameters
    ----------
    maps, poses
        All maps, and their placements in the component's frame.
    edges
        Agreeing candidates. Those that no other connects with a held map are left out.
    held
        Maps whose poses stay, at least one.
    params
        Parameters of the least squares.

    Returns
    -------
    dict
        New poses of the connected maps, by index.
    """
    connected = reached(held, [edge.pair for edge in edges])
    edges = [edge for edge in edges if edge.pair[0] in connected]
    named = sorted({index for edge in edges for index in edge.pair} | set(held))
    is_held = np.repeat([index in held for index in named], 2)
    fixed = np.concatenate([_normalised(poses[index], maps[index]) for index in named if index in held])
    column = {index: 2 * position for position, index in enumerate(named)}
    blocks = [_block(edge, maps) for edge in edges]
    current = {index: poses[index] for index in named}
    spare = len(edges) - len(connected) + len(set(held))  # pairs more than a tree has
    for iteration in range(params.iterations):
        residuals = np.array([_residual(edge, current) for edge in edges])
        sigma = max(_spread(residuals, spare, params), params.start_sigma / 2**iteration)
        matrix = np.zeros((2 * len(named), 2 * len(named)), np.complex128)
        for edge, block, residual in zip(edges, blocks, residuals, strict=True):
            at = [column[edge.pair[0]], column[edge.pair[0]] + 1, column[edge.pair[1]], column[edge.pair[1]] + 1]
            matrix[np.ix_(at, at)] += _weight(edge, residual, sigma, current, params) * block
        solved = _solve(matrix, is_held, fixed)
        moved = 0.0
        for index in named:
            if index in held:
                continue
            pose = _given(solved[column[index]], solved[column[index] + 1], maps[index])
            marks = maps[index].landmarks
            moved = max(moved, float(np.abs(pose.apply(marks) - current[index].apply(marks)).max()))
            current[index] = pose
        if moved < params.settled_cells and params.start_sigma / 2**iteration <= params.sigma:
            break
    return current


def _block(edge: PairCandidate, maps: Sequence[MapSample]) -> NDArray[np.complex128]:
    """Return the normal matrix of a pair over (turn, shift) of its first and of its second map, shape (4, 4)."""
    first, second = (maps[index] for index in edge.pair)
    q, p = (edge.images - first.centre) / first.radius, (edge.points - second.centre) / second.radius
    ones = np.ones_like(p)
    rows = np.stack([q, ones, -p, -ones], axis=1)  # (5, 4)
    block: NDArray[np.complex128] = rows.conj().T @ rows
    return block


def _residual(edge: PairCandidate, poses: dict[int, ComplexSimilarity]) -> float:
    """Return the RMS distance between the shared points of both maps as the poses lay them, in spans."""
    first, second = (poses[index] for index in edge.pair)
    return rms(first.apply(edge.images) - second.apply(edge.points)) / (edge.span * first.scale)


def _spread(residuals: NDArray[np.float64], spare: int, params: PlaceParams) -> float:
    """Return the residual in spans at which a pair has lost half its say, by their median; at most `params.sigma`."""
    if spare <= 0:
        return params.sigma
    freedom = math.sqrt(len(residuals) / spare)  # a fit draws its residuals together
    return min(params.sigma, max(params.min_sigma, params.sigmas * NORMAL_MAD * float(np.median(residuals)) * freedom))


def _weight(
    edge: PairCandidate, residual: float, sigma: float, poses: dict[int, ComplexSimilarity], params: PlaceParams
) -> float:
    """Return the weight of a pair's squared distances, of Geman and McClure."""
    unit = sigma * edge.span * poses[edge.pair[0]].scale
    return max(edge.overlap, params.min_overlap) / (unit * (1 + (residual / sigma) ** 2)) ** 2


def _solve(matrix: NDArray[np.complex128], is_held: NDArray[np.bool_], fixed: Points) -> Points:
    """Solve the normal equations with some unknowns held at fixed values."""
    solved = np.zeros(len(matrix), np.complex128)
    solved[is_held] = fixed
    right = -matrix[np.ix_(~is_held, is_held)] @ fixed
    solved[~is_held] = np.linalg.lstsq(matrix[np.ix_(~is_held, ~is_held)], right, rcond=None)[0]
    return solved


def _normalised(pose: ComplexSimilarity, sample: MapSample) -> Points:
    """Return (turn, shift) over coordinates about the map's centre in units of its radius, shape (2,)."""
    return np.array([pose.turn * sample.radius, pose.turn * sample.centre + pose.shift])


def _given(turn: complex, shift: complex, sample: MapSample) -> ComplexSimilarity:
    """Undo `_normalised`."""
    scaled = complex(turn) / sample.radius
    return ComplexSimilarity(scaled, complex(shift) - scaled * sample.centre)
