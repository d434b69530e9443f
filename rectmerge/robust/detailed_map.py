"""Detailed map: state, faces and corners of one map at nearly its own resolution, against which another is held."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.contradictions import FREE, UNKNOWN, WALL
from rectmerge._kernels.wall_cells import known_bounds
from rectmerge.analysis.distance_codes import distance_to
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.analysis.wall_faces import NORMALS, QUARTER, run_lengths
from rectmerge.robust.detail_params import DetailParams
from rectmerge.robust.features import by_radius, shrink, shrunk_offset

Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Faces of the walls of a detailed map; a thin wall has one on either side.

    Parameters
    ----------
    points
        Shape (F, 2): (u, v) in the detailed grid.
    is_long
        Shape (F,): whether the face is part of a long straight run.
    """

    points: NDArray[np.float64]
    is_long: NDArray[np.bool_]

    def spaced(self, most: int) -> Faces:
        """Return about `most` evenly spaced faces."""
        step = -(-len(self.points) // most) or 1
        return Faces(np.ascontiguousarray(self.points[::step]), np.ascontiguousarray(self.is_long[::step]))


@dataclass(frozen=True, slots=True, eq=False)
class DetailedMap:
    """State, faces and corners of one map, and the distances of its cells to them.

    Parameters
    ----------
    factor, offset
        A pixel p of the map is at ``p / factor + offset`` in the detailed grid.
    state
        Shape (h, w), uint8, as `rectmerge._kernels.contradictions` numbers it: unknown, free or wall.
    faces
        Its faces.
    corners, corner_kinds
        Shape (C, 2), (u, v) in the detailed grid, and (C,): 0 of a room, which the wall surrounds, 1 of a jamb, which
        the free space surrounds.
    to_corner, to_wall, to_unknown
        Distances in cells to the nearest corner of each kind, shape (2, h, w), wall, and unknown cell, (h, w).
    """

    factor: float
    offset: NDArray[np.float64]
    state: NDArray[np.uint8]
    faces: Faces
    corners: NDArray[np.float64]
    corner_kinds: NDArray[np.int64]
    to_corner: Image
    to_wall: Image
    to_unknown: Image

    @classmethod
    def from_cells(cls, cells: MapCells, angle: float, working_factor: float, params: DetailParams) -> DetailedMap:
        """Describe a map that has walls.

        Parameters
        ----------
        cells
            The map.
        angle
            Of its strongest direction, radians.
        working_factor
            Cells of the map per working cell, which long runs and the smoothing of corners are counted in.
        params
            Parameters of the description.
        """
        state, factor, offset = _state(cells, params)
        wall = state == WALL
        contrast = cv2.GaussianBlur((state == FREE) - wall.astype(np.float32), (0, 0), params.blur_cells)
        slopes = cv2.Sobel(contrast, cv2.CV_32F, 1, 0, ksize=3), cv2.Sobel(contrast, cv2.CV_32F, 0, 1, ksize=3)
        working_cell = working_factor / factor
        faces = _faces(state, slopes, angle, working_cell, params)
        corners, kinds = _corners(state, slopes, working_cell, params)
        return cls(
            factor=factor,
            offset=offset,
            state=state,
            faces=faces,
            corners=corners,
            corner_kinds=kinds,
            to_corner=np.stack([distance_to(_marked(corners[kinds == kind], state.shape)) for kind in range(2)]),
            to_wall=distance_to(wall),
            to_unknown=distance_to(state == UNKNOWN),
        )


def _state(cells: MapCells, params: DetailParams) -> tuple[NDArray[np.uint8], float, NDArray[np.float64]]:
    """Return the states of the detailed grid, its factor and its offset."""
    top, bottom, left, right = bounds = known_bounds(cells.values)
    factor = max(1.0, math.hypot(bottom - top + 1, right - left + 1) / params.diagonal_cells)
    n_free, n_occupied, *_ = shrink(cells, bounds, factor)
    occupied = np.pad(n_occupied > 0, params.margin_cells)
    free = np.pad(n_free > params.free_share * factor**2, params.margin_cells) & ~occupied
    _, labels, stats, _ = cv2.connectedComponentsWithStats(occupied.view(np.uint8), connectivity=8)
    is_speck = stats[:, cv2.CC_STAT_AREA] <= params.max_speck_cells
    is_speck[0] = False  # the background
    specks = is_speck[labels]
    state = np.where(occupied & ~specks, WALL, np.where(free | specks, FREE, UNKNOWN)).astype(np.uint8)
    return state, factor, shrunk_offset(bounds, factor, params.margin_cells)


def _faces(
    state: NDArray[np.uint8], slopes: tuple[Image, Image], angle: float, working_cell: float, params: DetailParams
) -> Faces:
    """Find the wall cells that border on free space, one face for each side that is free."""
    beside_free = cv2.dilate((state == FREE).view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    steep = slopes[0] ** 2 + slopes[1] ** 2 > params.min_slope**2
    v, u = np.nonzero((state == WALL) & beside_free & steep)
    points = np.column_stack([u, v]).astype(np.float64)
    normals = np.arctan2(slopes[1][v, u], slopes[0][v, u]).astype(np.float64)
    sides = []
    for reach in (params.free_at_cells, -params.free_at_cells):
        ahead = np.column_stack([np.cos(normals), np.sin(normals)]) * reach
        x, y = np.rint(points + ahead).astype(np.intp).T
        sides.append(state[y.clip(0, state.shape[0] - 1), x.clip(0, state.shape[1] - 1)] == FREE)
    front, back = sides
    points = np.concatenate([points[front], points[back]])
    normals = np.concatenate([normals[front], normals[back] + math.pi])
    order = by_radius(points)
    points, normals = points[order], normals[order]
    return Faces(points, _is_long(points, normals, angle, working_cell, params))


def _is_long(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    angle: float,
    working_cell: float,
    params: DetailParams,
) -> NDArray[np.bool_]:
    """Mark the faces of long straight runs along the map's strongest direction, shape (F,)."""
    quarters = np.rint((normals - angle) / QUARTER)
    off = np.abs(normals - angle - quarters * QUARTER)
    is_long = np.zeros(len(points), np.bool_)
    for k in range(NORMALS):
        mine = np.flatnonzero((quarters % NORMALS == k) & (off < math.radians(params.max_off_deg)))
        normal = np.array([math.cos(angle + k * QUARTER), math.sin(angle + k * QUARTER)])
        at = points[mine] / working_cell
        lengths = run_lengths(
            at @ normal, at @ [-normal[1], normal[0]],
            width_cells=params.run_width_cells, gap_cells=params.run_gap_cells,
        )  # fmt: skip
        is_long[mine] = lengths >= params.min_run_cells
    return is_long


def _corners(
    state: NDArray[np.uint8], slopes: tuple[Image, Image], working_cell: float, params: DetailParams
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Find the corners of walls and their kinds: maxima of the corner response.

    Harris and Stephens, "A combined corner and edge detector", Alvey Vision Conference 1988, DOI 10.5244/C.2.23.
    """
    sigma = params.corner_blur_cells * max(1.0, working_cell)
    xx, yy, xy = (
        cv2.GaussianBlur(product, (0, 0), sigma)
        for product in (slopes[0] * slopes[0], slopes[1] * slopes[1], slopes[0] * slopes[1])
    )
    response = xx * yy - xy * xy - params.corner_edge_weight * (xx + yy) ** 2
    wall = state == WALL
    if not wall.any():
        return np.empty((0, 2)), np.empty(0, np.int64)
    strong = params.corner_share * float(np.percentile(response[wall], params.corner_percentile))
    size = np.ones((params.corner_apart_cells, params.corner_apart_cells), np.uint8)
    is_corner = (response >= cv2.dilate(response, size)) & (response > strong)
    is_corner &= cv2.dilate(wall.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
    v, u = np.nonzero(is_corner)
    free = cv2.blur((state == FREE).astype(np.float32), (params.corner_window_cells, params.corner_window_cells))
    return np.column_stack([u, v]).astype(np.float64), (free[v, u] > 0.5).astype(np.int64)


def _marked(points: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.bool_]:
    mask = np.zeros(shape, np.bool_)
    u, v = points.astype(np.intp).T
    mask[v, u] = True
    return mask
