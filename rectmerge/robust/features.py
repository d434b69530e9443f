"""Features of one map: a small working grid, its wall points, and rectangles in its orthogonal frames."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import suppress
from rectmerge._kernels.wall_cells import count_walls, known_bounds, light_specks
from rectmerge.analysis.distance_codes import BINS, ON_BORDER, distance_codes, distance_to
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN
from rectmerge.rectangles import maximal_rectangles
from rectmerge.robust.params import FaceParams, PrepareParams

QUARTER_TURN_DEG = 90
ROUNDED_CELLS = 1e-6  # what rounding moves a distance by is less

Cells = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Features:
    """Working grid and wall points of a map, small enough to score thousands of placements.

    Parameters
    ----------
    factor, offset
        A pixel p of the map is at ``p / factor + offset`` in the working grid.
    free, known
        Masks of the working grid, shape (h, w).
    walls
        Wall points, shape (N, 2), (u, v) in the working grid: the mean surface position in each working wall cell.
    distance
        Shape (h, w), float32: from each working cell to the next wall cell, in working cells.
    distance_bins
        Shape (h, w), uint8: the same as codes of `rectmerge.analysis.distance_codes`.
    """

    factor: float
    offset: NDArray[np.float64]
    free: NDArray[np.bool_]
    known: NDArray[np.bool_]
    walls: NDArray[np.float64]
    distance: NDArray[np.float32]
    distance_bins: NDArray[np.uint8]

    @functools.cached_property
    def distance_counts(self) -> NDArray[np.intp]:
        """Known cells in each bin of the distance to a wall, shape (BINS,)."""
        return np.bincount(self.distance_bins.ravel(), minlength=ON_BORDER)[:BINS]

    @functools.cached_property
    def landmarks(self) -> NDArray[np.float64]:
        """Four points around the walls at the radius of their spread, shape (4, 2): where a placement is compared."""
        middle = self.walls.mean(axis=0)
        radius = self.radius
        landmarks: NDArray[np.float64] = middle + radius * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
        return landmarks

    @functools.cached_property
    def radius(self) -> float:
        """Root mean square distance of the walls from their centroid, in working cells."""
        return float(np.sqrt(((self.walls - self.walls.mean(axis=0)) ** 2).sum(axis=1).mean()))

    def faces(self, angle: float, params: FaceParams) -> WallFaces:
        """Group the wall points by outward normal; normal 0 is at an angle. They are made once."""
        key = angle, params
        if key not in self._faces:
            self._faces[key] = WallFaces.from_walls(
                self.walls, self.free, self.known, angle,
                free_at_cells=params.free_at_cells, min_run_cells=params.min_run_cells,
                run_width_cells=params.run_width_cells, run_gap_cells=params.run_gap_cells,
            )  # fmt: skip
        return self._faces[key]

    @functools.cached_property
    def _faces(self) -> dict[tuple[float, FaceParams], WallFaces]:
        return {}


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The maximal empty rectangles of a map in one orthogonal frame.

    Parameters
    ----------
    angle
        Of the frame's first axis in the working grid, radians from u towards v.
    boxes
        Shape (N, 4): centre (u, v) in the working grid, width and height along the frame's axes; best first.
    has_wall
        Shape (N, 4), bool: whether the left, right, top and bottom side runs along a wall.
    """

    angle: float
    boxes: NDArray[np.float64]
    has_wall: NDArray[np.bool_]


def extract_features(cells: MapCells, params: PrepareParams) -> Features | None:
    """Shrink a map to its working grid; None where no wall borders on free space.

    The grid is as coarse as the map's passages allow: its free cells keep a mean clearance of six cells.
    """
    bounds = known_bounds(cells.values)
    top, bottom, left, right = bounds
    if bottom < 0:
        return None
    diagonal = math.hypot(bottom - top + 1, right - left + 1)
    features, clearance = _shrunk(cells, bounds, max(1.0, diagonal / params.diagonal_cells), params)
    if features is None or clearance >= params.mean_clearance_cells or features.factor == 1.0:
        return features
    finer = min(params.max_diagonal_cells, params.diagonal_cells * params.mean_clearance_cells / clearance)
    return _shrunk(cells, bounds, max(1.0, diagonal / finer), params)[0]


def _shrunk(
    cells: MapCells, bounds: tuple[int, int, int, int], factor: float, params: PrepareParams
) -> tuple[Features | None, float]:
    """Return the features at a shrinking factor, and the mean clearance of their free cells."""
    n_free, n_occupied, n_surface, sum_u, sum_v = (
        np.pad(c, params.margin_cells) for c in shrink(cells, bounds, factor)
    )
    occupied = n_occupied > 0
    free = (n_free >= params.free_share * factor**2) & ~occupied
    # holes between diverging rays are free: nearly half of what surrounds them is
    free |= (cv2.blur(free.astype(np.float32), (3, 3)) > params.free_neighbours_share) & ~occupied
    working = np.where(occupied, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8)
    working.flags.writeable = False  # as a map's own cells, for which the kernel is compiled
    heaviest = int(params.max_speck_weight * max(1.0, factor / params.speck_factor) ** 2)
    specks = light_specks(working, n_occupied, heaviest, params.max_speck_cells)
    occupied, free = occupied & ~specks, free | specks
    beside_free = cv2.dilate(free.view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    wall = (n_surface > 0) & beside_free & occupied
    if not wall.any():
        return None, 0.0
    offset = shrunk_offset(bounds, factor, params.margin_cells)
    surface = np.stack([sum_u[wall], sum_v[wall]], axis=1) / n_surface[wall][:, None]  # (N, 2) in the map's pixels
    surface = surface[by_radius(surface)]
    distance = distance_to(wall)
    clearance = cv2.distanceTransform(free.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_3)
    known = free | occupied
    features = Features(
        factor=factor,
        offset=offset,
        free=free,
        known=known,
        walls=surface / factor + offset,
        distance=distance,
        distance_bins=distance_codes(distance, known),
    )
    return features, float(clearance[free].mean()) if free.any() else 0.0


def shrink(cells: MapCells, bounds: tuple[int, int, int, int], factor: float) -> tuple[NDArray[Any], ...]:
    """Count the free, occupied and surface cells of each working cell, and sum the surface cells' u and v.

    Parameters
    ----------
    cells
        The map; its specks count as free.
    bounds
        First and last row and column to use.
    factor
        Cells of the map per working cell, each way; >= 1.
    """
    (row_start, rows), (col_start, cols) = (_working_ends(side, factor) for side in _sides(bounds))
    shape = (len(rows) - 1, len(cols) - 1)
    walls = count_walls(cells.rows, cells.cols, cells.kinds, bounds, factor, (row_start, col_start), shape)
    return cells.free_counts(rows + bounds[0], cols + bounds[2]) + walls[0], *walls[1:]


def shrunk_offset(bounds: tuple[int, int, int, int], factor: float, margin_cells: int) -> NDArray[np.float64]:
    """Return the offset of a grid that `shrink` made and a margin surrounds: pixel p is at ``p / factor + offset``."""
    starts = np.array([_division(side, factor)[1] for side in _sides(bounds)[::-1]])
    return margin_cells - 0.5 + (0.5 + starts - np.array([bounds[2], bounds[0]], np.float64)) / factor


def by_radius(points: NDArray[np.float64]) -> NDArray[np.intp]:
    """Order points by the distance from their centroid, shape (N,).

    Samples of the points in this order are the same however the map is turned, mirrored or cut to what is known.
    """
    radii = np.hypot(*(points - points.mean(axis=0)).T) if len(points) else np.empty(0)
    return np.argsort(np.rint(radii / ROUNDED_CELLS), kind="stable")


def _sides(bounds: tuple[int, int, int, int]) -> tuple[int, int]:
    return bounds[1] - bounds[0] + 1, bounds[3] - bounds[2] + 1


def _division(side: int, factor: float) -> tuple[int, float]:
    """Divide a side into working cells about its middle: return their number, and how far they begin before it.

    About the middle, a map turned or mirrored is divided alike.
    """
    count = math.ceil(side / factor)
    count += side % 2 and (side - count) % 2  # an even number would divide an odd side's middle cell
    return count, (count * factor - side) / 2


def _working_ends(side: int, factor: float) -> tuple[float, NDArray[np.intp]]:
    """Return how far the working cells begin before a side, and the cells at which each begins, and the side's end."""
    count, start = _division(side, factor)
    working = np.minimum(count - 1, ((np.arange(side) + 0.5 + start) / factor).astype(np.intp))
    return start, np.searchsorted(working, np.arange(count + 1))


def rectangles_in_frame(features: Features, angle: float, params: PrepareParams) -> Frame:
    """List the map's maximal empty rectangles in the frame at an angle: large ones first, near doubles left out."""
    height, width = features.free.shape
    cos, sin = math.cos(angle), math.sin(angle)
    size = (int(width * abs(cos) + height * abs(sin)) + 3, int(width * abs(sin) + height * abs(cos)) + 3)
    turn = np.array([[cos, sin], [-sin, cos]])
    shift = (np.array(size) - 1) / 2 - turn @ ((np.array([width, height]) - 1) / 2)
    free = cv2.warpAffine(features.free.astype(np.float32), np.column_stack([turn, shift]), size) > 0.5
    wall = np.zeros(free.shape, np.uint8)
    u, v = np.rint(features.walls @ turn.T + shift).astype(np.int64).T
    wall[v, u] = 1
    free &= wall == 0
    rectangles = maximal_rectangles(free, min_side_cells=params.min_side_cells)
    near_wall = np.asarray(cv2.dilate(wall, np.ones((3, 3), np.uint8)), np.uint8)
    support = _wall_shares(near_wall, rectangles)
    w, h = rectangles[:, 2].astype(np.float64), rectangles[:, 3].astype(np.float64)
    worth = np.sqrt(w * h) * (params.unsupported_worth + support.mean(axis=1))
    worth *= np.minimum(1, np.minimum(w, h) / params.full_side_cells)
    kept = suppress(rectangles, np.argsort(-worth, kind="stable"), params.max_iou, params.max_rectangles)
    centres = (rectangles[kept, :2] + (rectangles[kept, 2:] - 1) / 2 - shift) @ turn
    boxes = np.column_stack([centres, rectangles[kept, 2:]]).astype(np.float64)
    return Frame(angle, boxes, support[kept] >= params.min_wall_share)


def _wall_shares(near_wall: NDArray[np.uint8], rectangles: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the share of the left, right, top and bottom side of each rectangle along a wall, shape (N, 4)."""
    total = cv2.integral(near_wall)
    height, width = near_wall.shape
    x, y, w, h = rectangles.T

    def inside(x0: Cells, y0: Cells, dx: Cells | int, dy: Cells | int) -> Cells:
        left, right = np.clip(x0, 0, width), np.clip(x0 + dx, 0, width)
        top, bottom = np.clip(y0, 0, height), np.clip(y0 + dy, 0, height)
        counts: Cells = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
        return counts

    sides = (
        inside(x - 1, y, 1, h) / h,
        inside(x + w, y, 1, h) / h,
        inside(x, y - 1, w, 1) / w,
        inside(x, y + h, w, 1) / w,
    )
    return np.stack(sides, axis=1)
