"""Test of a displacement on squares that it was not fitted to: four-fold cross-validation over the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.elastic.fit import ElasticFit
from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.matching import FacePair
from rectmerge.elastic.params import AcceptanceParams

FOLDS = 4
FAR = 1 << 20  # squares from one row of the board to the next, as one number


@dataclass(frozen=True, slots=True)
class HeldBack:
    """Gain of a displacement on walls that it was not fitted to.

    Parameters
    ----------
    cost_ratio
        Cost of the walls after over before; below 1 they meet better.
    gain_t
        Mean of the squares' gains over its standard error.
    met
        Share of the walls, of both maps, that meet after it: 1 less their mean cost, 0..1.
    squares
        Number of squares with enough faces.
    fits
        The displacements, each fitted without a quarter of the squares.
    """

    cost_ratio: float
    gain_t: float
    met: float
    squares: int
    fits: tuple[Displacement, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Board:
    """Squares over A, and the square of each sampled face of both maps.

    Parameters
    ----------
    squares_a, squares_b
        Column and row of the square of each sampled face, shape (N, 2).
    """

    squares_a: NDArray[np.intp]
    squares_b: NDArray[np.intp]

    @classmethod
    def over(cls, pair: FacePair, side: float) -> Board:
        """Lay squares of `side` cells over the sampled faces; B's faces count where the similarity puts them."""
        points = pair.a.points[pair.sample_a], pair.placed[pair.sample_b]
        a, b = (np.floor(at / side).astype(np.intp) for at in points)
        return cls(a, b)

    def folds(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the fold, 0 to 3, of each sampled face of A, and of B: squares of one fold touch nowhere."""
        a, b = (squares % 2 @ np.array([1, 2]) for squares in (self.squares_a, self.squares_b))
        return a, b


def hold_back(fitting: ElasticFit, board: Board, params: AcceptanceParams) -> HeldBack:
    """Fit to three quarters of the squares and measure on the others, four times.

    Notes
    -----
    Cost of a face: its squared distance across the wall to its partner, over a reach, at most 1; a face without
    partner costs 1. The ratio and the gains leave out faces that the other map does not show: without partner before
    and after, and not in its free space.
    """
    pair = fitting.pair
    none, reach = Displacement.none(fitting.lattice), params.reach_cells(pair.diagonal)
    before, after, squares, is_shown, fits = [], [], [], [], []
    fold_a, fold_b = board.folds()
    for fold in range(FOLDS):
        held_a, held_b = fold_a == fold, fold_b == fold
        fits.append(fitting.fit(pair.sample_a[~held_a], pair.sample_b[~held_b]))
        held = pair.sample_a[held_a], pair.sample_b[held_b]
        before.append(costs(pair, none, reach, *held))
        after.append(costs(pair, fits[-1], reach, *held))
        squares.append(np.concatenate([board.squares_b[held_b], board.squares_a[held_a]]))
        is_shown.append((before[-1] < 1) | (after[-1] < 1) | pair.in_free_space(*held))
    ratio, t, met, count = _gain(
        np.concatenate(before),
        np.concatenate(after),
        np.concatenate(squares),
        np.concatenate(is_shown),
        params.min_square_faces,
    )
    return HeldBack(ratio, t, met, count, tuple(fits))


def costs(
    pair: FacePair, displacement: Displacement, reach: float, of_a: NDArray[np.intp], of_b: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return the cost of each face, 0..1, B's faces first."""
    matches = pair.moved(displacement, of_a, of_b).match(reach)
    parts = [np.where(m.is_matched, np.minimum(1.0, (m.across() / reach) ** 2), 1.0) for m in matches]
    return np.concatenate(parts)


def _gain(
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    squares: NDArray[np.intp],
    is_shown: NDArray[np.bool_],
    min_faces: int,
) -> tuple[float, float, float, int]:
    """Sum costs over all faces and by square: the first four fields of `HeldBack`."""
    met = float(1 - after.mean()) if len(after) else 0.0
    before, after = before[is_shown], after[is_shown]
    if not before.any():
        return math.inf, 0.0, met, 0
    _, square = np.unique(squares[is_shown] @ np.array([1, FAR]), return_inverse=True)
    gains = np.bincount(square, before - after)[np.bincount(square) >= min_faces]
    error = float(gains.std(ddof=1)) / math.sqrt(len(gains)) if len(gains) > 1 else 0.0
    t = float(gains.mean()) / error if error > 0 else 0.0
    return float(after.sum() / before.sum()), t, met, len(gains)
