"""How two maps agree under a given placement: overlap and conflict, from their cells alone."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

CONFLICT_REACH_CELLS = 2  # a wall this close to the other map's wall agrees with it


@dataclass(frozen=True, slots=True)
class Agreement:
    """How two maps agree under a placement; every figure lies in 0..1.

    Parameters
    ----------
    overlap
        ``|free A and T free B| / min(|free A|, |T free B|)``, areas in A's frame.
    iou
        The same intersection over the union.
    conflict
        Of the wall cells of either map that fall on known cells of the other, the share that falls on free space
        away from any wall. 0 where no wall falls on known cells.
    """

    overlap: float
    iou: float
    conflict: float


def measure_agreement(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> Agreement:
    """Measure overlap and conflict of B placed on A by the pixel similarity `pixels`."""
    free_a, free_b = a.free, b.free
    area_a, area_b = float(free_a.sum()), float(free_b.sum()) * pixels.scale**2
    common = float((free_a & _sample(free_b, pixels, free_a.shape)).sum())
    bad_b, seen_b = _walls_on_free(b, a, pixels)
    bad_a, seen_a = _walls_on_free(a, b, pixels.inverse())
    return Agreement(
        overlap=min(1.0, common / max(1.0, min(area_a, area_b))),
        iou=min(1.0, common / max(1.0, area_a + area_b - common)),
        conflict=(bad_a + bad_b) / max(1, seen_a + seen_b),
    )


def _sample(mask_b: NDArray[np.bool_], pixels: Similarity, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Read a mask of B at every cell of A: nearest cell, False outside B."""
    read = cv2.warpAffine(mask_b.view(np.uint8), pixels.matrix, shape[::-1], flags=cv2.INTER_NEAREST)
    return read.astype(np.bool_)


def _walls_on_free(source: OccupancyGrid, target: OccupancyGrid, pixels: Similarity) -> tuple[int, int]:
    """Count `source` walls that fall on free space of `target` away from its walls, and those on known cells."""
    points = np.argwhere(source.occupied)[:, ::-1]  # (N, 2) as (u, v)
    u, v = np.rint(pixels.apply(points)).astype(np.int64).T
    inside = (u >= 0) & (v >= 0) & (u < target.shape[1]) & (v < target.shape[0])
    cells = v[inside], u[inside]
    size = 2 * CONFLICT_REACH_CELLS + 1
    near_wall = cv2.dilate(target.occupied.view(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_)
    known = ~target.unknown[cells] | near_wall[cells]
    on_free = target.free[cells] & ~near_wall[cells]
    return int(on_free.sum()), int(known.sum())
