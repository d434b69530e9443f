"""What speaks for a placement, in numbers: how the faces of both maps' walls meet, and what they have in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import add_scores, invert
from rectmerge._kernels.tallying import tally
from rectmerge.overlap import cells_of
from rectmerge.robust.distances import BINS, EDGES_CELLS, IN_UNKNOWN
from rectmerge.robust.features import Features
from rectmerge.robust.sides import QUARTER, Sides

CODES = 128
MET_CELLS, NEAR_CELLS, FAR_CELLS = 1.5, 4.0, 8.0  # edges of bins: how far a face may be from the face that it meets
SAMPLED_FLOOR = 2000  # free cells that stand for all where overlaps are compared
SAME_TURN = math.radians(2.0)  # placements that turn alike share the sides of B
BESIDE_CELLS = 3.0
DEEP_CELLS = 8.0  # a wall this far from the other map's walls, in its free space, is missing there


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """What speaks for each of N placements; every array has shape (N,).

    Parameters
    ----------
    judged
        Faces of walls that fall where the other map can tell, of both maps, counted by the coarser map's cells.
    met, near, far
        Shares of these within 1.5 cells of a face of the other map that looks the same way, within 4, and beyond 8.
    missing
        Share of the walls on known cells of the other map that lie deep in its free space, whichever way they face.
    overlap, iou
        Of the free space: over the smaller area, and over the union.
    """

    judged: NDArray[np.float64]
    met: NDArray[np.float64]
    near: NDArray[np.float64]
    far: NDArray[np.float64]
    missing: NDArray[np.float64]
    overlap: NDArray[np.float64]
    iou: NDArray[np.float64]

    def of(self, which: NDArray[np.intp]) -> Weights:
        """Return the weights of some of the placements."""
        return Weights(**{field.name: getattr(self, field.name)[which] for field in fields(self)})

    def at(self, which: int) -> dict[str, float]:
        """Return the weights of one placement, by name."""
        return {field.name: float(getattr(self, field.name)[which]) for field in fields(self)}


def weigh(placements: NDArray[np.float64], a: Features, b: Features, angle: float) -> Weights:
    """Weigh placements of B on A, rows (a, b, tx, ty) between the working grids.

    Parameters
    ----------
    angle
        Of the directions in A that faces are sorted by, radians: those of its walls.
    """
    counts = _counts(placements, a, b, angle)  # (N, CODES)
    free = counts[:, :BINS]
    beyond = counts[:, IN_UNKNOWN : IN_UNKNOWN + BINS]
    judged = free.sum(axis=1) + _within(beyond, NEAR_CELLS / 2)
    some = np.maximum(judged, 1.0)
    overlap, iou = _overlaps(placements, a, b)
    return Weights(
        judged=judged,
        met=(_within(free, MET_CELLS) + _within(beyond, MET_CELLS)) / some,
        near=(_within(free, NEAR_CELLS) + _within(beyond, NEAR_CELLS / 2)) / some,
        far=1.0 - (_within(free, FAR_CELLS) + _within(beyond, NEAR_CELLS / 2)) / some,
        missing=np.array([_missing(placement, a, b) for placement in placements]),
        overlap=overlap,
        iou=iou,
    )


def _within(counts: NDArray[np.float64], cells: float) -> NDArray[np.float64]:
    """Sum the counts of distances below an edge of bins, shape (N,)."""
    sums: NDArray[np.float64] = counts[:, : int(np.searchsorted(EDGES_CELLS, cells))].sum(axis=1)
    return sums


def _counts(placements: NDArray[np.float64], a: Features, b: Features, angle: float) -> NDArray[np.float64]:
    """Count the codes that the faces of both maps meet in the other, by the coarser map's cells, shape (N, CODES)."""
    on_a, back = Sides.of(a, angle), invert(placements)
    scales = np.hypot(placements[:, 0], placements[:, 1])
    turns = np.arctan2(placements[:, 1], placements[:, 0])
    alike = np.rint((angle - turns) % QUARTER / SAME_TURN)
    forward = np.zeros((len(placements), CODES), np.int32)
    backward = np.zeros_like(forward)
    for key in np.unique(alike):
        which = np.flatnonzero(alike == key)
        on_b = Sides.of(b, float((angle - turns[which[0]]) % QUARTER))
        quarters = np.rint((on_b.angle + turns[which] - angle) / QUARTER).astype(np.int64) % 4
        met = np.zeros((2, len(which), CODES), np.int32)
        tally(placements[which], quarters, b.walls, on_b.faces, on_a.codes, met[0])
        tally(back[which], -quarters % 4, a.walls, on_a.faces, on_b.codes, met[1])
        forward[which], backward[which] = met
    counts: NDArray[np.float64] = (
        forward * np.minimum(1.0, scales)[:, None] + backward * np.minimum(1.0, 1 / scales)[:, None]
    )
    return counts


def _overlaps(
    placements: NDArray[np.float64], a: Features, b: Features
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Estimate what the free spaces share, of the smaller and of the union, from evenly spaced free cells of B."""
    floor = np.ascontiguousarray(cells_of(b.free, SAMPLED_FLOOR)[:, ::-1].T, np.float32)
    hits = np.zeros(len(placements), np.int64)
    add_scores(placements, floor, a.free.astype(np.int32), hits)
    area_a, area_b = np.count_nonzero(a.free), np.count_nonzero(b.free) * (placements[:, :2] ** 2).sum(axis=1)
    common = np.minimum(hits / max(1, floor.shape[1]) * area_b, np.minimum(area_a, area_b))
    return common / np.maximum(1.0, np.minimum(area_a, area_b)), common / np.maximum(1.0, area_a + area_b - common)


def _missing(placement: NDArray[np.float64], a: Features, b: Features) -> float:
    back = invert(placement[None])[0]
    deep_b, known_b = _walls_in(a, placement, b.walls, DEEP_CELLS)
    deep_a, known_a = _walls_in(b, back, a.walls, DEEP_CELLS * math.hypot(back[0], back[1]))
    return (deep_b + deep_a) / max(1, known_b + known_a)


def _walls_in(
    other: Features, placement: NDArray[np.float64], walls: NDArray[np.float64], deep: float
) -> tuple[int, int]:
    """Count the walls that lie deep in a map's free space, and those on its known cells or beside its walls."""
    a, b, tx, ty = placement
    u = np.rint(a * walls[:, 0] - b * walls[:, 1] + tx).astype(np.intp)
    v = np.rint(b * walls[:, 0] + a * walls[:, 1] + ty).astype(np.intp)
    height, width = other.free.shape
    inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    cells = v[inside], u[inside]
    distance = other.distance[cells]
    is_deep = other.free[cells] & (distance > deep)
    return int(is_deep.sum()), int((other.known[cells] | (distance < BESIDE_CELLS)).sum())
