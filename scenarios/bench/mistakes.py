"""Common mistakes with a 2x3 matrix between two images, and the detection of the one that a method makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.grid import OccupancyGrid
from scenarios.pairs.pair import MapPair
from scenarios.scoring.score import RIGHT, grade, measure_errors

Affine = NDArray[np.float64]  # shape (3, 3), homogeneous
LEAST_MORE_RIGHT = 2  # answers, once a mistake is undone, before it is named
LEAST_SHARE_RIGHT = 2 / 3
FINER = 0.5  # of the error of answers that are right already


@dataclass(frozen=True, slots=True)
class Mistake:
    """A mistake by name.

    Parameters
    ----------
    name
        For tests and tables.
    advice
        What is wrong, and what to do about it.
    undo
        Takes a matrix in which the mistake was made, and its pair, to the matrix that was meant.
    """

    name: str
    advice: str
    undo: Callable[[Affine, MapPair], Affine]

    def undone(self, matrix: ArrayLike, pair: MapPair) -> NDArray[np.float64]:
        """Return the 2x3 matrix that was meant by one in which the mistake was made."""
        return self.undo(np.vstack([np.asarray(matrix, dtype=np.float64), (0.0, 0.0, 1.0)]), pair)[:2]


def name_mistake(answers: Sequence[tuple[MapPair, NDArray[np.float64]]]) -> Mistake | None:
    """Name the mistake that, once undone, makes a method's answers right, shape (2, 3) each; None if none does.

    Notes
    -----
    All pairs decide together: on a single one a mistake may change nothing, as the sign of no turn does, or two may do
    the same. Undoing the mistake that is named leaves most answers right, of equals with the least error; they are two
    thirds of all, and two more than as they stand, or as many with half the error.
    """
    errors = {mistake.name: _errors([(pair, mistake.undone(m, pair)) for pair, m in answers]) for mistake in MISTAKES}
    best = min(MISTAKES, key=lambda mistake: (-_count(errors[mistake.name]), _rms(errors[mistake.name])))
    as_it_is, undone = _errors(answers), errors[best.name]
    if _count(undone) < max(LEAST_MORE_RIGHT, LEAST_SHARE_RIGHT * len(answers)):
        return None
    is_finer = _count(undone) >= _count(as_it_is) and _rms(undone) < FINER * _rms(as_it_is)
    return best if is_finer or _count(undone) >= _count(as_it_is) + LEAST_MORE_RIGHT else None


def _errors(answers: Sequence[tuple[MapPair, NDArray[np.float64]]]) -> NDArray[np.float64]:
    """Return the error of each answer in cells of A, infinite where it is not right, shape (N,)."""
    measured = [measure_errors(matrix, pair) for pair, matrix in answers]
    return np.array([each.e_px if grade(each, 0.0) in RIGHT else math.inf for each in measured])


def _count(errors: NDArray[np.float64]) -> int:
    return int(np.isfinite(errors).sum())


def _rms(errors: NDArray[np.float64]) -> float:
    right = errors[np.isfinite(errors)]
    return float(np.sqrt((right**2).mean())) if len(right) else math.inf


def _flip(grid: OccupancyGrid) -> Affine:
    """Turn v upside down, as arrays with row 0 at the bottom have it."""
    return np.array([[1.0, 0.0, 0.0], [0.0, -1.0, grid.shape[0] - 1.0], [0.0, 0.0, 1.0]])


def _to_frame(grid: OccupancyGrid) -> Affine:
    """Return the matrix from a grid's pixels to its map frame."""
    at, right, down = grid.pixel_to_map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    return np.column_stack([[*(right - at), 0.0], [*(down - at), 0.0], [*at, 1.0]])


def _centre(grid: OccupancyGrid) -> NDArray[np.float64]:
    return (np.array(grid.shape[::-1]) - 1.0) / 2.0


def _moved(x: float, y: float) -> Affine:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def _with_linear(m: Affine, linear: NDArray[np.float64]) -> Affine:
    changed = m.copy()
    changed[:2, :2] = linear
    return changed


def _angle_from_degrees(m: Affine, pair: MapPair) -> Affine:
    """Find the angle whose degrees were taken for radians; of those that look alike modulo a turn, the likeliest."""
    turns = np.arange(-29, 30)
    angles = np.radians(math.atan2(m[1, 0], m[0, 0]) + math.tau * turns)
    true = pair.pixels.angle if pair.pixels else 0.0
    off = np.abs(np.remainder(angles - true + math.pi, math.tau) - math.pi)
    angle, scale = float(angles[np.argmin(off)]), math.hypot(m[0, 0], m[1, 0])
    a, b = scale * math.cos(angle), scale * math.sin(angle)
    return _with_linear(m, np.array([[a, -b], [b, a]]))


def _in_pixels(m: Affine, pair: MapPair) -> Affine:
    undone = m.copy()
    undone[:2, 2] /= pair.a.cell_size
    return undone


SWAP: Affine = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
MISTAKES = (
    Mistake("inverse", "your matrix takes A to B: invert it", lambda m, pair: np.asarray(np.linalg.inv(m))),
    Mistake(
        "v flipped in A",
        "your v runs upwards in A: pixels have v down, so take H - 1 - v there",
        lambda m, pair: _flip(pair.a) @ m,
    ),
    Mistake(
        "v flipped in B",
        "your v runs upwards in B: pixels have v down, so take H - 1 - v there",
        lambda m, pair: m @ _flip(pair.b),
    ),
    Mistake(
        "v flipped in both",
        "your v runs upwards in both maps: pixels have v down, so take H - 1 - v in each",
        lambda m, pair: _flip(pair.a) @ m @ _flip(pair.b),
    ),
    Mistake(
        "map frame",
        "your matrix is between the map frames (v up, from the origin): turn it into one between pixel centres",
        lambda m, pair: np.linalg.inv(_to_frame(pair.a)) @ m @ _to_frame(pair.b),
    ),
    Mistake(
        "row and column swapped",
        "your points are (row, col): the matrix is between points (u, v) = (col, row)",
        lambda m, pair: SWAP @ m @ SWAP,
    ),
    Mistake(
        "half a pixel",
        "you count from pixels' corners: the matrix is between pixel centres, off by 0.5 - s R 0.5",
        lambda m, pair: _moved(-0.5, -0.5) @ m @ _moved(0.5, 0.5),
    ),
    Mistake("degrees", "your angle is in degrees where radians are taken: convert it", _angle_from_degrees),
    Mistake(
        "scale inverted",
        "your scale is cells of B per cell of A: take its inverse",
        lambda m, pair: _with_linear(m, m[:2, :2] / abs(np.linalg.det(m[:2, :2]))),
    ),
    Mistake(
        "metres", "your translation is in metres: it must be in pixels, so divide it by A's resolution", _in_pixels
    ),
    Mistake(
        "about B's centre",
        "you turn about the centre of B's image: the matrix turns about pixel (0, 0)",
        lambda m, pair: _moved(*_centre(pair.b)) @ m @ _moved(*-_centre(pair.b)),
    ),
    Mistake(
        "about both centres",
        "your points count from the centres of both images: the matrix takes pixels from (0, 0)",
        lambda m, pair: _moved(*_centre(pair.a)) @ m @ _moved(*-_centre(pair.b)),
    ),
    Mistake(
        "rotation sign",
        "your rotation has the wrong sign: angles between pixels run clockwise to the eye, because v is down",
        lambda m, pair: _with_linear(m, m[:2, :2].T),
    ),
)
