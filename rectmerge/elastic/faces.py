"""Wall faces of a map with smooth normals, and the nearest face that looks a given way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.face_lookup import nearest_facing, smooth_normals
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.derived import derive
from rectmerge.elastic.params import FaceParams
from rectmerge.grid import OccupancyGrid


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Wall faces of a map, in its pixels.

    Parameters
    ----------
    points
        Shape (N, 2): (u, v) of each occupied cell beside free space.
    normals
        Shape (N, 2): unit normals into that space.
    labels
        Shape (directions, h, w), int32: number of the nearest face that looks about that way, -1 where there is none.
    factor
        Cells of the map per cell of `labels`, at least 1.
    corner
        (u, v) of the first cell of `labels`, which surround the walls.
    free
        Shape (H, W): free cells of the map.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    labels: NDArray[np.int32]
    factor: float
    corner: NDArray[np.float64]
    free: NDArray[np.bool_]

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, params: FaceParams) -> Faces:
        """Find the faces of a map and the nearest one of each direction at each place, once within `derived_kept`."""
        return derive(grid, (cls, params), lambda: cls._find(grid, params))

    @classmethod
    def _find(cls, grid: OccupancyGrid, params: FaceParams) -> Faces:
        cells = MapCells.from_grid(grid)
        is_face = cells.normals.any(axis=1)
        points = np.column_stack([cells.cols[is_face], cells.rows[is_face]]).astype(np.int64)
        normals = cells.normals[is_face].astype(np.float64)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        if not len(points):
            return cls(
                points.astype(np.float64), normals, np.full((1, 1, 1), -1, np.int32), 1.0, np.zeros(2), grid.free
            )
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        index = np.full(extent[::-1] + 1, -1, np.int32)
        index[points[:, 1] - low[1], points[:, 0] - low[0]] = np.arange(len(points))
        normals = smooth_normals(index, points - low, normals, params.normal_reach_cells, params.same_normal_cos)
        diagonal = float(np.hypot(*extent))
        factor = max(1.0, diagonal / params.label_diagonal_cells)
        corner = low - math.ceil(params.label_margin * diagonal)
        labels = _label((points - corner) / factor, normals, (extent + 2 * (low - corner)) / factor, params)
        return cls(points.astype(np.float64), normals, labels, factor, corner.astype(np.float64), grid.free)

    def nearest(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the number of the nearest face that looks like each normal, (N,); -1 where there is none."""
        return nearest_facing(self.labels, self.factor, points - self.corner, normals)

    def in_free_space(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether points, (N, 2), lie in free cells of the map."""
        u, v = np.rint(points).astype(np.intp).T
        height, width = self.free.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        free: NDArray[np.bool_] = inside & self.free[v.clip(0, height - 1), u.clip(0, width - 1)]
        return free


def _label(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    extent: NDArray[np.float64],
    params: FaceParams,
) -> NDArray[np.int32]:
    """Label each cell of a grid of an extent (width, height) by its nearest face in each direction."""
    width, height = (int(side) + 2 for side in extent)
    u, v = np.rint(points).astype(np.intp).T
    labels = np.full((params.directions, height, width), -1, np.int32)
    for k in range(params.directions):
        angle = (k + 0.5) * math.tau / params.directions
        facing = np.flatnonzero(normals @ [math.cos(angle), math.sin(angle)] > params.direction_cos)
        if not len(facing):
            continue
        elsewhere = np.ones((height, width), np.uint8)
        elsewhere[v[facing], u[facing]] = 0
        _, found = cv2.distanceTransformWithLabels(elsewhere, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
        face_of = np.full(int(found.max()) + 1, -1, np.int32)
        face_of[found[v[facing], u[facing]]] = facing
        labels[k] = face_of[found]
    return labels
