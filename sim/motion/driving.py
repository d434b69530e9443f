"""Drive fields: clearance of every cell of a world, drivable cells, spots to stand on and shortest paths."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.errors import SimulationError
from sim._kernels import paths
from sim.world import Room, World, covers

ROBOT_RADIUS_M, ROBOT_HEIGHT_M = 0.2, 0.3
KEEP_OFF_M = 0.3  # centre of the robot to the nearest obstacle, at least
COMFORT_M = 0.6  # closer than this to an obstacle, a path costs more
CELL_M = 0.1
OFF_THE_WAY_M = 0.5  # largest distance from a robot pushed aside to the drivable part


@dataclass(frozen=True, slots=True, eq=False)
class DriveField:
    """Clearance of every cell of a world, and the mask of its largest drivable part.

    Parameters
    ----------
    clearance
        Shape (H, W), metres to the nearest obstacle, row 0 at the bottom.
    is_drivable
        Shape (H, W).
    """

    clearance: NDArray[np.float64]
    is_drivable: NDArray[np.bool_]

    def prices(self) -> NDArray[np.float64]:
        """Return the cost of a metre in each cell: 1, more near obstacles, inf where there is no driving."""
        return np.where(self.is_drivable, 1.0 + 6.0 * np.maximum(0.0, COMFORT_M - self.clearance), np.inf)


def make_drive_field(world: World) -> DriveField:
    """Make the drive field of a world: obstacles that the laser does not see count as well.

    Raises
    ------
    SimulationError
        If the world has no floor, or none that is wide enough.
    """
    if not (world.rooms or world.floor):
        raise SimulationError(f"this {world.family or 'world'} has no floor: neither rooms nor floor outlines")
    met = tuple(replace(p, bottom=0.0) for p in world.obstacles if p.bottom < ROBOT_HEIGHT_M)
    free = replace(world, walls=met, furniture=(), glass=()).raster(CELL_M / 2, height_m=0.0).free[::-1]
    free = np.pad(free, ((0, free.shape[0] % 2), (0, free.shape[1] % 2)))
    # in single precision: of clearances that are just what is asked, data sets made before decide alike
    clearance = exact_distance(~np.pad(free, 1))[1:-1, 1:-1].astype(np.float32) * (CELL_M / 2)
    clearance = np.minimum.reduce([clearance[r::2, c::2] for r in (0, 1) for c in (0, 1)])
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        (clearance >= KEEP_OFF_M).astype(np.uint8), connectivity=4
    )
    if count < 2:
        raise SimulationError(f"a robot fits nowhere in this {world.family or 'world'}")
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    return DriveField(clearance.astype(np.float64), labels == largest)


def find_standing_spot(field: DriveField, room: Room) -> NDArray[np.float64] | None:
    """Choose a roomy spot (x, y) near the middle of a room, in the drivable part; None where there is none."""
    rows, cols = np.nonzero(field.is_drivable)
    points = cell_centres(rows, cols)  # (N, 2)
    inside = covers(room.outline, points)
    if not inside.any():
        return None
    roomy = np.minimum(field.clearance[rows[inside], cols[inside]], 1.0)
    offset = points[inside] - room.outline.mean(axis=0)
    spot: NDArray[np.float64] = points[inside][np.argmax(roomy - 0.1 * np.hypot(offset[:, 0], offset[:, 1]))]
    return spot


def costs_from(prices: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cost in cells from every cell to the drivable one nearest to a point; inf where there is no path.

    `prices` are those of `DriveField.prices`, shape (H, W).
    """
    if not np.isfinite(prices).any():
        return np.full(prices.shape, np.inf)
    return paths.cost_to_goal(prices, *nearest_cell(np.isfinite(prices), point))


def path_to_goal(costs: NDArray[np.float64], start: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the path from a point down a field of `costs_from`, to its goal.

    Returns
    -------
    NDArray or None
        Waypoints, shape (N, 2), metres, about one per cell; None where no path begins within half a metre of the start.
    """
    if not np.isfinite(costs).any():
        return None
    row, col = nearest_cell(np.isfinite(costs), start)
    if math.hypot((col + 0.5) * CELL_M - start[0], (row + 0.5) * CELL_M - start[1]) > OFF_THE_WAY_M:
        return None
    return cell_centres(*paths.descend(costs, row, col).T)


def path_from_start(costs: NDArray[np.float64], goal: tuple[int, int]) -> NDArray[np.float64]:
    """Return the path (N, 2) from the start of a field of `costs_from` to a cell that it reaches."""
    return cell_centres(*paths.descend(costs, *goal)[::-1].T)


def find_best_goal(
    prices: NDArray[np.float64], start: NDArray[np.float64], pay: NDArray[np.float32]
) -> tuple[NDArray[np.float64], tuple[int, int] | None]:
    """Find the cell with the largest pay less the cost of the path to it.

    Parameters
    ----------
    prices
        As `DriveField.prices` gives them, shape (H, W).
    start
        Start of the path, (2,), metres.
    pay
        Pay of each cell, in cells of comfortable driving, shape (H, W); 0 where it is no goal.

    Returns
    -------
    costs, cell
        The cost in cells from the start, shape (H, W), no further than needed, and the cell; None where none pays.
    """
    costs, at = paths.find_best_goal(prices, *nearest_cell(np.isfinite(prices), start), pay, float(pay.max()))
    return costs, None if at < 0 else divmod(at, prices.shape[1])


class PathPlanner:
    """Planner of shortest paths over one drive field; the costs from a goal are computed once."""

    def __init__(self, drive: DriveField) -> None:
        self.prices = drive.prices()
        self._costs: dict[tuple[int, int], NDArray[np.float64]] = {}

    def costs(self, goal: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the cost in cells between every cell and a goal."""
        cell = nearest_cell(np.isfinite(self.prices), goal)
        if cell not in self._costs:
            self._costs[cell] = paths.cost_to_goal(self.prices, *cell)
        return self._costs[cell]

    def cost_m(self, start: NDArray[np.float64], goal: NDArray[np.float64]) -> float:
        """Return the cost of the path between two points, in metres of comfortable driving."""
        return cost_m(self.costs(goal), start)

    def path(
        self, start: NDArray[np.float64], goal: NDArray[np.float64], blocked: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64] | None:
        """Return the path (N, 2), off blocked cells (H, W); None where there is none."""
        if blocked is None:
            return path_to_goal(self.costs(goal), start)
        return path_to_goal(costs_from(np.where(blocked, np.inf, self.prices), goal), start)


def cost_m(costs: NDArray[np.float64], start: NDArray[np.float64]) -> float:
    """Read a field of `costs_from` at a point, in metres of comfortable driving."""
    return float(costs[nearest_cell(np.isfinite(costs), start)]) * CELL_M


def disc_mask(shape: tuple[int, ...], centre: NDArray[np.float64], radius_m: float) -> NDArray[np.bool_]:
    """Return the mask (H, W) of the cells whose centres lie within a radius of a point in metres."""
    rows, cols = (np.arange(n) * CELL_M + CELL_M / 2 for n in shape)
    inside: NDArray[np.bool_] = (rows[:, None] - centre[1]) ** 2 + (cols - centre[0]) ** 2 < radius_m**2
    return inside


def cell_centres(rows: NDArray[np.int64], cols: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the centres of cells of a drive field, shape (N, 2), metres."""
    centres: NDArray[np.float64] = (np.stack([cols, rows], axis=-1).astype(np.float64) + 0.5) * CELL_M
    return centres


def cell_centre(row: int, col: int) -> NDArray[np.float64]:
    """Return the centre of one cell, (2,), metres."""
    return np.array([(col + 0.5) * CELL_M, (row + 0.5) * CELL_M])


def cell_at(point: NDArray[np.float64]) -> tuple[int, int]:
    """Return the (row, col) of the cell that a point in metres lies in, inside the grid or not."""
    return math.floor(point[1] / CELL_M), math.floor(point[0] / CELL_M)


def nearest_drivable(field: DriveField, point: NDArray[np.float64]) -> tuple[int, int]:
    """Return the drivable (row, col) nearest to a point in metres."""
    return nearest_cell(field.is_drivable, point)


def nearest_cell(mask: NDArray[np.bool_], point: NDArray[np.float64]) -> tuple[int, int]:
    """Return the (row, col) of a mask that is nearest to a point in metres; the mask must not be empty."""
    row, col = cell_at(point)
    if 0 <= row < mask.shape[0] and 0 <= col < mask.shape[1] and mask[row, col]:
        return row, col
    rows, cols = np.nonzero(mask)
    away = np.hypot((cols + 0.5) * CELL_M - point[0], (rows + 0.5) * CELL_M - point[1])
    k = int(np.argmin(away))
    return int(rows[k]), int(cols[k])
