"""Frontier exploration: a robot drives to where what it has seen meets what it has not.

B. Yamauchi, A frontier-based approach for autonomous exploration, CIRA 1997.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.coverage import SeenFloor
from sim.driving import CELL_M, Ways, cell_centres, costs_from, disc, nearest_cell, way_down

LEAST_FRONTIER_CELLS = 5  # shorter ones are gaps between beams, and no robot fits through
LOOK_FROM_CELLS = 5  # how far from a frontier a robot stands to look beyond it
GIVEN_UP_M = 1.0  # around where a robot stood and still did not see beyond
LENGTH_PAYS, LONGEST_PAYS_M = 1.0, 2.0  # a metre of frontier is worth so many metres of way, up to a length
EIGHT = np.ones((3, 3), dtype=np.uint8)
FOUR = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)).astype(np.uint8)


@dataclass(slots=True, eq=False)
class Frontiers:
    """Guides one robot from frontier to frontier over the floor that its own scans have shown.

    Where a robot fits is read off the true plan, as if bumpers told; what there is to explore, and which ways it
    knows, comes from its scans alone.

    Parameters
    ----------
    ways
        Where it can drive.
    seen
        What it has seen; it grows while the robot drives.
    home
        Where it returns at the end; None where it does not.
    """

    ways: Ways
    seen: SeenFloor
    home: NDArray[np.float64] | None = None
    note: str = ""
    is_done: bool = False
    _is_over: bool = False
    _at: tuple[int, int] = (0, 0)  # the cell where the way ends
    _window: tuple[slice, slice] = (slice(0), slice(0))  # around it, wide enough to hold the frontier it is about
    _unknown: int = 0  # cells of the window that were unknown when the way was planned
    _given_up: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self._given_up = np.zeros(self.seen.since.shape, dtype=np.bool_)

    @property
    def goal(self) -> str:
        """Where it is going, for people."""
        return "its start" if self._is_over else "the next frontier"

    def look(self) -> bool:
        """Tell whether the way should be planned anew, since scans have shown most of what it was to show."""
        if self._is_over or not self._unknown:
            return False
        return int(np.count_nonzero(self._is_unknown(self._window))) < self._unknown / 2

    def path(
        self, position: NDArray[np.float64], blocked: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64] | None:
        """Plan the way to the most promising frontier, or home, off blocked cells (H, W); None where there is none.

        Where none is left to explore, exploration is over.
        """
        prices = np.where(self.seen.is_free, self.ways.prices, np.inf)
        if blocked is not None:
            prices[blocked] = np.inf
        if not np.isfinite(prices).any():
            return None
        costs = costs_from(prices, position)
        goal = None if self._is_over else self._choose(costs)
        if goal is None and blocked is None and not self._is_over:
            self.finish()
        if self._is_over and self.home is not None:
            goal = nearest_cell(np.isfinite(costs), self.home)
        if goal is None:
            return None
        self._aim(goal)
        back = way_down(costs, cell_centres(*(np.array([k]) for k in goal))[0])
        return None if back is None else back[::-1]

    def arrive(self) -> None:
        """Give up what can still not be seen from here; at home, be done."""
        if self._is_over:
            self.is_done = True
        self.put_off()

    def put_off(self) -> None:
        """Give up the frontier that it was going to."""
        at = cell_centres(*(np.array([k]) for k in self._at))[0]
        self._given_up |= disc(self._given_up.shape, at, GIVEN_UP_M)

    def finish(self) -> None:
        """Explore no more: go home, or end here."""
        self._is_over = True
        self.is_done = self.home is None

    def _choose(self, costs: NDArray[np.float64]) -> tuple[int, int] | None:
        """Choose the known cell from which to look beyond a frontier: near, and the frontier long."""
        known = self.seen.is_free
        frontier = known & (cv2.dilate(self._is_unknown().view(np.uint8), FOUR) > 0) & ~self._given_up
        _, labels, stats, _ = cv2.connectedComponentsWithStats(frontier.view(np.uint8), connectivity=8)
        cells = stats[:, cv2.CC_STAT_AREA].astype(np.float32)
        pays = np.where(cells >= LEAST_FRONTIER_CELLS, np.minimum(cells * CELL_M, LONGEST_PAYS_M), 0.0)
        pays[0] = 0.0  # what is no frontier
        pay = pays.astype(np.float32)[labels]
        for _ in range(LOOK_FROM_CELLS):  # over known cells only, never through a wall
            pay = np.where(known, cv2.dilate(pay, EIGHT), np.float32(0.0))
        score = np.where(pay > 0, costs * CELL_M - LENGTH_PAYS * pay, np.inf)
        goal = divmod(int(np.argmin(score)), score.shape[1])
        return goal if np.isfinite(score[goal]) else None

    def _aim(self, goal: tuple[int, int]) -> None:
        self._at, reach = goal, LOOK_FROM_CELLS + 3
        self._window = tuple(slice(max(0, k - reach), k + reach + 1) for k in goal)  # type: ignore[assignment]
        self._unknown = int(np.count_nonzero(self._is_unknown(self._window)))

    def _is_unknown(self, window: tuple[slice, slice] = (slice(None), slice(None))) -> NDArray[np.bool_]:
        """Cells that are neither seen free nor beside a hit: between two beams that met a wall there is wall."""
        wall = cv2.dilate(np.ascontiguousarray(self.seen.is_hit[window]).view(np.uint8), EIGHT) > 0
        unknown: NDArray[np.bool_] = (self.seen.since[window] < 0) & ~wall
        return unknown
