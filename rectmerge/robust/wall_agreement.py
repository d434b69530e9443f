"""What speaks for a placement, in numbers: how the faces of both maps' walls meet, and what they have in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.code_counts import count_codes
from rectmerge._kernels.placements import add_scores, invert
from rectmerge.analysis.distance_codes import BINS, EDGES_CELLS, IN_UNKNOWN
from rectmerge.analysis.overlap import cells_of
from rectmerge.analysis.wall_faces import QUARTER, WallFaces
from rectmerge.robust.features import Features

CODES = 128
MET_CELLS, NEAR_CELLS, FAR_CELLS = 1.5, 4.0, 8.0  # edges of bins of the distance to a face that looks the same way
SAMPLED_FLOOR = 2000  # free cells that stand for all where overlaps are compared
SAME_TURN = math.radians(3.0)  # placements that turn alike share the sides of B
BESIDE_CELLS = 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class WallAgreement:
    """What speaks for each of N placements; every array has shape (N,).

    Parameters
    ----------
    judged
        Faces of walls that fall where the other map can tell, of both maps, counted by the coarser map's cells.
    matched, near, contradicted
        Shares of these within 1.5 cells of a face of the other map that looks the same way, within 4, and beyond 8.
    clutter, clutter_matched, clutter_contradicted
        The same of faces that are in no long run: things may have been moved between the visits.
    violations
        Share of the walls on known cells of the other map that lie deep in its free space, whichever way they face.
    overlap, iou
        Of the free space: over the smaller area, and over the union.
    """

    judged: NDArray[np.float64]
    matched: NDArray[np.float64]
    near: NDArray[np.float64]
    contradicted: NDArray[np.float64]
    clutter: NDArray[np.float64]
    clutter_matched: NDArray[np.float64]
    clutter_contradicted: NDArray[np.float64]
    violations: NDArray[np.float64]
    overlap: NDArray[np.float64]
    iou: NDArray[np.float64]

    def take(self, which: NDArray[np.intp]) -> Self:
        """Return some of the placements, in this order."""
        return type(self)(**{field.name: getattr(self, field.name)[which] for field in fields(self)})

    def concat(self, other: Self) -> Self:
        """Return this one's placements and another's."""
        names = [field.name for field in fields(self)]
        return type(self)(**{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names})


class AgreementScorer:
    """Two maps made ready for placements of B on A to be weighed.

    Parameters
    ----------
    a, b
        The features.
    angle
        Of the directions in A that faces are sorted by, radians: those of its walls.
    """

    def __init__(self, a: Features, b: Features, angle: float) -> None:
        self._a, self._b, self._angle = a, b, angle
        self._on_a = a.faces(angle)
        self._on_b: dict[int, WallFaces] = {}
        self._floor = np.ascontiguousarray(cells_of(b.free, SAMPLED_FLOOR)[:, ::-1].T, np.float32)

    def score(self, placements: NDArray[np.float64]) -> WallAgreement:
        """Weigh placements, rows (a, b, tx, ty) between the working grids."""
        walls, things = self._faces_met(placements)
        judged, met, near, far = _shares(walls)
        some, clutter_matched, _, clutter_contradicted = _shares(things)
        overlap, iou = self._overlaps(placements)
        return WallAgreement(
            judged=judged,
            matched=met,
            near=near,
            contradicted=far,
            clutter=some,
            clutter_matched=clutter_matched,
            clutter_contradicted=clutter_contradicted,
            violations=self._violations(placements),
            overlap=overlap,
            iou=iou,
        )

    def _faces_met(self, placements: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Count the codes that long faces and others of both maps meet, by the coarser map's cells, (N, CODES) each."""
        back = invert(placements)
        turns = np.arctan2(placements[:, 1], placements[:, 0])
        alike = np.rint((self._angle - turns) % QUARTER / SAME_TURN).astype(int)
        forward = np.zeros((2, len(placements), CODES), np.int32)
        backward = np.zeros_like(forward)
        for key in np.unique(alike):
            which = np.flatnonzero(alike == key)
            on_b = self._sides_of_b(int(key))
            quarters = np.rint((on_b.angle + turns[which] - self._angle) / QUARTER).astype(np.int64) % 4
            of_a, of_b = ((side.faces & side.is_long, side.faces & ~side.is_long) for side in (self._on_a, on_b))
            for kind in range(2):
                forward[kind, which] = _tallied(
                    placements[which], quarters, self._b.walls, of_b[kind], self._on_a.codes
                )
                backward[kind, which] = _tallied(back[which], -quarters % 4, self._a.walls, of_a[kind], on_b.codes)
        walls = _by_coarser_cells(placements, forward[0], backward[0])
        return walls, _by_coarser_cells(placements, forward[1], backward[1])

    def _sides_of_b(self, key: int) -> WallFaces:
        if key not in self._on_b:
            self._on_b[key] = self._b.faces(key * SAME_TURN)
        return self._on_b[key]

    def _overlaps(self, placements: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Estimate what the free spaces share, of the smaller and of the union, from evenly spaced free cells of B."""
        hits = np.zeros(len(placements), np.int64)
        add_scores(placements, self._floor, self._a.free.astype(np.int32), hits)
        area_a = np.count_nonzero(self._a.free)
        area_b = np.count_nonzero(self._b.free) * (placements[:, :2] ** 2).sum(axis=1)
        common = np.minimum(hits / max(1, self._floor.shape[1]) * area_b, np.minimum(area_a, area_b))
        return common / np.maximum(1.0, np.minimum(area_a, area_b)), common / np.maximum(1.0, area_a + area_b - common)

    def _violations(self, placements: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of both maps' walls on cells that the other knows which lie deep in its free space, shape (N,)."""
        ways = np.zeros(len(placements), np.int64)
        one, two = (np.ones((len(f.walls), 1), np.bool_) for f in (self._a, self._b))
        forward = _tallied(placements, ways, self._b.walls, two, self._a.distance_bins[None])
        backward = _tallied(invert(placements), ways, self._a.walls, one, self._b.distance_bins[None])
        counts = _by_coarser_cells(placements, forward, backward)
        known = counts[:, :BINS].sum(axis=1) + _within(counts[:, IN_UNKNOWN:], BESIDE_CELLS)
        missing: NDArray[np.float64] = _beyond(counts, FAR_CELLS) / np.maximum(known, 1.0)
        return missing


def _within(counts: NDArray[np.float64], cells: float) -> NDArray[np.float64]:
    """Sum the counts of distances below an edge of bins, shape (N,)."""
    sums: NDArray[np.float64] = counts[:, : int(np.searchsorted(EDGES_CELLS, cells))].sum(axis=1)
    return sums


def _shares(counts: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """How many faces could be judged by the codes they met, and the shares of them that are met, near and far."""
    free, beyond = counts[:, :BINS], counts[:, IN_UNKNOWN : IN_UNKNOWN + BINS]
    judged = free.sum(axis=1) + _within(beyond, NEAR_CELLS / 2)
    some = np.maximum(judged, 1.0)
    met = (_within(free, MET_CELLS) + _within(beyond, MET_CELLS)) / some
    near = (_within(free, NEAR_CELLS) + _within(beyond, NEAR_CELLS / 2)) / some
    return judged, met, near, _beyond(free, FAR_CELLS) / some


def _beyond(counts: NDArray[np.float64], cells: float) -> NDArray[np.float64]:
    """Sum the counts of distances from an edge of bins on, shape (N,)."""
    sums: NDArray[np.float64] = counts[:, int(np.searchsorted(EDGES_CELLS, cells)) : BINS].sum(axis=1)
    return sums


def _tallied(
    placements: NDArray[np.float64],
    quarters: NDArray[np.int64],
    points: NDArray[np.float64],
    faces: NDArray[np.bool_],
    codes: NDArray[np.uint8],
) -> NDArray[np.int32]:
    counts = np.zeros((len(placements), CODES), np.int32)
    count_codes(placements, quarters, points, faces, codes, counts)
    return counts


def _by_coarser_cells(
    placements: NDArray[np.float64], forward: NDArray[np.int32], backward: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Add up what both maps' points met; where cells differ in size, the finer map's points count for less."""
    scales = np.hypot(placements[:, 0], placements[:, 1])[:, None]
    return np.asarray(forward * np.minimum(1.0, scales) + backward * np.minimum(1.0, 1 / scales), np.float64)
