"""Frontier exploration: a robot drives to the border between seen and unseen floor.

B. Yamauchi, A frontier-based approach for autonomous exploration, CIRA 1997.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.motion.coverage import SeenFloor
from sim.motion.driving import (
    PathPlanner,
    cell_centre,
    cell_centres,
    costs_from,
    disc_mask,
    find_best_goal,
    path_from_start,
    path_to_goal,
)

AROUND_CELLS, LEAST_FRONTIER_CELLS = 15, 5  # less frontier within a square so wide is gaps between beams
LOOK_FROM_CELLS = 5  # distance from which a robot looks beyond a frontier
GIVEN_UP_M = 1.0  # radius around a frontier that could not be seen beyond
EIGHT = np.ones((3, 3), dtype=np.uint8)
FOUR = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)).astype(np.uint8)


@dataclass(slots=True, eq=False)
class Frontiers:
    """Guide of one robot from frontier to frontier over the floor that its own scans have shown.

    The drivable cells are those of the true plan, as if from bumpers; frontiers and known floor come from its scans
    alone.

    Parameters
    ----------
    planner
        Path planner.
    seen
        Floor that it has seen; it grows while the robot drives.
    home
        Start to return to at the end; None for no return.
    """

    planner: PathPlanner
    seen: SeenFloor
    home: NDArray[np.float64] | None = None
    note: str = ""
    is_done: bool = False
    _is_over: bool = False
    _at: tuple[int, int] = (0, 0)  # the last cell of the path
    _window: tuple[slice, slice] = (slice(0), slice(0))  # around that cell, wide enough for its frontier
    _aim: NDArray[np.bool_] = field(init=False)  # the frontier in the window when the path was planned
    _given_up: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self._given_up = np.zeros(self.seen.since.shape, dtype=np.bool_)
        self._aim = np.zeros((0, 0), dtype=np.bool_)

    @property
    def goal(self) -> str:
        """Name of the next goal, for notes."""
        return "its start" if self._is_over else "the next frontier"

    @property
    def faces(self) -> NDArray[np.float64] | None:
        """Point to look at from the goal, (2,): the middle of the frontier; None at home."""
        if self._is_over or not self._aim.any():
            return None
        rows, cols = np.nonzero(self._aim)
        middle: NDArray[np.float64] = cell_centres(rows + self._window[0].start, cols + self._window[1].start).mean(
            axis=0
        )
        return middle

    def is_path_outdated(self) -> bool:
        """Return whether scans have moved most of the frontier that the path leads to."""
        if self._is_over or not self._aim.any():
            return False
        left = np.count_nonzero(self._frontier(self._window) & self._aim)
        return bool(left < np.count_nonzero(self._aim) / 2)

    def path(
        self, position: NDArray[np.float64], blocked: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64] | None:
        """Plan the path to the most promising frontier, or home, off blocked cells (H, W); None where there is none.

        Exploration is over where no frontier is left.
        """
        prices = np.where(self.seen.is_free, self.planner.prices, np.inf)
        if blocked is not None:
            prices[blocked] = np.inf
        if not np.isfinite(prices).any():
            return None
        if not self._is_over:
            for pay in self._pays():
                costs, goal = find_best_goal(prices, position, pay)
                if goal is not None:
                    self._aim_at(goal)
                    return path_from_start(costs, goal)
            if blocked is not None:
                return None
            self.finish()
        return None if self.home is None else path_to_goal(costs_from(prices, self.home), position)

    def arrive(self) -> None:
        """Give up the frontier that cannot be seen beyond from here; at home, be done."""
        if self._is_over:
            self.is_done = True
        self.put_off()

    def put_off(self) -> None:
        """Give up the present frontier."""
        self._given_up |= disc_mask(self._given_up.shape, cell_centre(*self._at), GIVEN_UP_M)

    def finish(self) -> None:
        """Explore no more: go home, or end here."""
        self._is_over = True
        self.is_done = self.home is None

    def _pays(self) -> Iterator[NDArray[np.float32]]:
        """Yield the pay of each known cell, in cells of path, for a look from there: more for a longer frontier.

        Where no path leads to those, short ones on drivable cells count: one may be a narrow passage.
        """
        frontier = self._frontier((slice(None), slice(None)))
        length = cv2.boxFilter(frontier.astype(np.float32), -1, (AROUND_CELLS, AROUND_CELLS), normalize=False)
        known = self.seen.is_free.astype(np.float32)
        for counts in (frontier & (length >= LEAST_FRONTIER_CELLS), frontier & np.isfinite(self.planner.prices)):
            pay = np.where(counts, length, np.float32(0.0))
            for _ in range(LOOK_FROM_CELLS):  # over known cells only, never through a wall
                cv2.dilate(pay, EIGHT, dst=pay)
                cv2.multiply(pay, known, dst=pay)
            yield pay

    def _aim_at(self, goal: tuple[int, int]) -> None:
        self._at, reach = goal, LOOK_FROM_CELLS + 3
        rows, cols = (slice(max(0, k - reach), k + reach + 1) for k in goal)
        self._window = rows, cols
        self._aim = self._frontier(self._window)

    def _frontier(self, window: tuple[slice, slice]) -> NDArray[np.bool_]:
        """Return the mask of cells of a window that are free, next to unknown ones, and not given up.

        Unknown cells are neither free nor next to a hit: between two beams that met a wall there is wall.
        """
        free = self.seen.since[window] >= 0
        wall = cv2.dilate(np.ascontiguousarray(self.seen.is_hit[window]).view(np.uint8), EIGHT) > 0
        beside_unknown = cv2.dilate((~free & ~wall).view(np.uint8), FOUR) > 0
        frontier: NDArray[np.bool_] = free & beside_unknown & ~self._given_up[window]
        return frontier
