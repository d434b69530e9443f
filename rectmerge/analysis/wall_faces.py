"""Wall points grouped by outward normal: a wall seen from its left is not the wall seen from its right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.distance_codes import BINS, IN_UNKNOWN, distance_codes, distance_to

QUARTER = math.pi / 2
EIGHTH = QUARTER / 2
NORMALS = 4  # of the faces of an orthogonal frame


def rounded_turn(angle: float | NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Round an angle to eighths of a turn: return its whole quarters, and 1 where an eighth is left over."""
    eighths = np.rint(np.asarray(angle) / EIGHTH).astype(np.int64)
    return eighths // 2, eighths % 2


@dataclass(frozen=True, slots=True, eq=False)
class WallFaces:
    """Faces of a map's wall points by outward normal, and distances of its cells to the nearest wall of each normal.

    Normal k points at about ``angle + k * 90`` degrees, from u towards v in the grid.

    Parameters
    ----------
    walls
        Shape (N, 2): wall points, (u, v) in the grid.
    free
        Shape (h, w): free cells of the grid.
    angle
        Of normal 0, radians.
    faces
        Shape (N, 4), bool: the wall point has free space in the direction of the normal.
    is_long
        Shape (N, 4), bool: the face is part of a long straight run.
    codes
        Shape (4, h, w), uint8: codes of `rectmerge.analysis.distance_codes` for the distance to walls with each normal.
        `IN_UNKNOWN` is added where the map is not free: a wall that another map has there contradicts nothing.
    counts
        Shape (4, BINS): known cells by their distance to walls with each normal.
    """

    walls: NDArray[np.float64]
    free: NDArray[np.bool_]
    angle: float
    faces: NDArray[np.bool_]
    is_long: NDArray[np.bool_]
    codes: NDArray[np.uint8]
    counts: NDArray[np.intp]

    @classmethod
    def from_walls(
        cls,
        walls: NDArray[np.float64],
        free: NDArray[np.bool_],
        known: NDArray[np.bool_],
        angle: float,
        *,
        free_at_cells: tuple[float, ...],
        min_run_cells: float,
        run_width_cells: float,
        run_gap_cells: float,
    ) -> WallFaces:
        """Group the wall points of a map by outward normal.

        Parameters
        ----------
        walls
            Shape (N, 2): wall points, (u, v) in the grid.
        free, known
            Masks of the grid, shape (h, w).
        angle
            Of normal 0, radians.
        free_at_cells
            Distances along the normal at which the map must be free.
        min_run_cells
            Length from which a straight run is long.
        run_width_cells, run_gap_cells
            Sideways spread and interruption that a run may have.
        """
        height, width = free.shape
        faces = np.ones((len(walls), NORMALS), np.bool_)
        is_long = np.zeros_like(faces)
        codes = np.empty((NORMALS, height, width), np.uint8)
        counts = np.empty((NORMALS, BINS), np.intp)
        for k in range(NORMALS):
            normal = np.array([math.cos(angle + k * QUARTER), math.sin(angle + k * QUARTER)])
            for cells in free_at_cells:
                u, v = np.rint(walls + cells * normal).astype(np.intp).T
                faces[:, k] &= free[v.clip(0, height - 1), u.clip(0, width - 1)]
            facing = walls[faces[:, k]]
            lengths = run_lengths(
                facing @ normal, facing @ [-normal[1], normal[0]], width_cells=run_width_cells, gap_cells=run_gap_cells
            )
            is_long[faces[:, k], k] = lengths >= min_run_cells
            u, v = np.rint(facing).astype(np.intp).T
            marked = np.zeros((height, width), np.bool_)
            marked[v, u] = True
            codes[k] = distance_codes(distance_to(marked), free)
            counts[k] = np.bincount(codes[k][known] % IN_UNKNOWN, minlength=BINS)[:BINS]
        return cls(walls, free, angle, faces, is_long, codes, counts)


def run_lengths(
    across: NDArray[np.float64], along: NDArray[np.float64], *, width_cells: float, gap_cells: float
) -> NDArray[np.float64]:
    """Measure the straight run of each point, shape (N,): neighbours close in `along` and equal in `across`."""
    if len(across) == 0:
        return np.empty(0)
    lane = np.rint(across / width_cells)
    order = np.lexsort((along, lane))
    breaks = (np.diff(lane[order]) != 0) | (np.diff(along[order]) > gap_cells)
    run = np.concatenate([[0], np.cumsum(breaks)])
    first = np.flatnonzero(np.diff(run, prepend=-1))
    last = np.append(first[1:], len(run)) - 1
    lengths = np.empty(len(across))
    lengths[order] = (along[order][last] - along[order][first])[run]
    return lengths
