"""Methods that know the truth of the easy pairs and answer it with one mistake; for a process of their own."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity
from scenarios.bench.external_program import MATRIX
from scenarios.pairs.drawn_pairs import easy_pairs
from scenarios.pairs.pair import MapPair

OFF = Similarity(1.0004, 0.0004, 0.05, -0.04)  # no method is exact
EXCHANGED = np.array([[0.0, 1.0], [1.0, 0.0]])


def upwards(points: np.ndarray, grid: OccupancyGrid) -> np.ndarray:
    return np.stack([points[:, 0], grid.shape[0] - 1 - points[:, 1]], axis=-1)


def centre(grid: OccupancyGrid) -> np.ndarray:
    return np.array([(grid.shape[1] - 1) / 2, (grid.shape[0] - 1) / 2])


def through(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The 2x3 matrix that takes points to points, mirrored or not."""
    return np.linalg.lstsq(np.column_stack([source, np.ones(len(source))]), target, rcond=None)[0].T


def mistaken_matrix(name: str, pair: MapPair) -> np.ndarray:
    """The answer to a pair with a mistake, by where it says that points of B lie in A."""
    true = OFF @ pair.pixels
    b = np.array([[0.0, 0.0], [90.0, 10.0], [20.0, 70.0]])
    a = true.apply(b)
    s, angle, tx, ty = true.scale, true.angle, true.tx, true.ty
    return {
        "none": lambda: true.matrix,
        "inverse": lambda: through(a, b),
        "v flipped in A": lambda: through(b, upwards(a, pair.a)),
        "v flipped in B": lambda: through(upwards(b, pair.b), a),
        "v flipped in both": lambda: through(upwards(b, pair.b), upwards(a, pair.a)),
        "map frame": lambda: pixels_to_map_frame(true, pair.a, pair.b).matrix,
        "row and column swapped": lambda: through(b[:, ::-1], a[:, ::-1]),
        "half a pixel": lambda: through(b + 0.5, a + 0.5),
        "degrees": lambda: Similarity(s, math.degrees(angle), tx, ty).matrix,
        "scale inverted": lambda: Similarity(1 / s, angle, tx, ty).matrix,
        "metres": lambda: Similarity(s, angle, tx * pair.a.cell_size, ty * pair.a.cell_size).matrix,
        "about B's centre": lambda: through(b - centre(pair.b), a - centre(pair.b)),
        "about both centres": lambda: through(b - centre(pair.b), a - centre(pair.a)),
        "rotation sign": lambda: Similarity(s, -angle, tx, ty).matrix,
        "lost": lambda: Similarity(s * 1.3, angle + 1.0, tx + 60, ty).matrix,
    }[name]()


@dataclass(frozen=True, kw_only=True)
class Mistaken:
    """Answers easy pairs as it is told to."""

    name: str = "mistaken"
    mistake: str = "none"
    verdict: str = "accepted"
    confidence: float = 0.9
    misbehaves: Callable[[], None] | None = None

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        matrix = next((mistaken_matrix(self.mistake, pair) for pair in easy_pairs() if is_of(pair, a, b)), np.eye(2, 3))
        if self.misbehaves is not None:
            self.misbehaves()
        near = Candidate.from_pixels(Similarity(), a, b, confidence=self.confidence)
        return Alignment(
            verdict=self.verdict,
            reason="as told",
            method=self.name,
            candidates=(near,),
            confidence=self.confidence,
            trace={MATRIX: matrix.tolist()},
        )


@dataclass(frozen=True, kw_only=True)
class Restless:
    """Draws from what is not its seed."""

    name: str = "restless"

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        mistaken = Mistaken().align(a, b, scale=scale, rng=rng)
        shifted = np.array(mistaken.trace[MATRIX])
        shifted[0, 2] += np.random.default_rng().normal(0.0, 0.01)
        return replace(mistaken, trace={MATRIX: shifted.tolist()})


@dataclass(frozen=True, kw_only=True)
class Torn:
    """Says one thing between pixels and another between map frames."""

    name: str = "torn"

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        true = next((pair.pixels for pair in easy_pairs() if is_of(pair, a, b)), Similarity())
        best = Candidate(b_to_a=true, pixels=true, confidence=0.9, overlap=0.5, conflict=0.0)
        return Alignment(verdict="accepted", reason="", method=self.name, candidates=(best,), confidence=0.9)


def is_of(pair: MapPair, a: OccupancyGrid, b: OccupancyGrid) -> bool:
    return np.array_equal(pair.a.occupancy, a.occupancy) and np.array_equal(pair.b.occupancy, b.occupancy)


def leave() -> None:
    os._exit(7)


def fail() -> None:
    raise ZeroDivisionError("no corners")
