"""Frontier exploration: a robot drives to where what it has seen meets what it has not.

B. Yamauchi, A frontier-based approach for autonomous exploration, CIRA 1997.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.motion.coverage import SeenFloor
from sim.motion.driving import Ways, cell_centre, cell_centres, costs_from, disc, most_gain, way_down, way_up

AROUND_CELLS, LEAST_FRONTIER_CELLS = 15, 5  # within a square so wide less frontier is but gaps between beams
LOOK_FROM_CELLS = 5  # how far from a frontier a robot stands to look beyond it
GIVEN_UP_M = 1.0  # around where a robot stood and still did not see beyond
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
    _aim: NDArray[np.bool_] = field(init=False)  # the frontier in the window when the way was planned
    _given_up: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self._given_up = np.zeros(self.seen.since.shape, dtype=np.bool_)
        self._aim = np.zeros((0, 0), dtype=np.bool_)

    @property
    def goal(self) -> str:
        """Where it is going, for people."""
        return "its start" if self._is_over else "the next frontier"

    @property
    def faces(self) -> NDArray[np.float64] | None:
        """Where to look from the goal, (2,): at the middle of the frontier; None at home."""
        if self._is_over or not self._aim.any():
            return None
        rows, cols = np.nonzero(self._aim)
        middle: NDArray[np.float64] = cell_centres(rows + self._window[0].start, cols + self._window[1].start).mean(
            axis=0
        )
        return middle

    def look(self) -> bool:
        """Tell whether the way should be planned anew, since scans have moved most of the frontier it leads to."""
        if self._is_over or not self._aim.any():
            return False
        left = np.count_nonzero(self._frontier(self._window) & self._aim)
        return bool(left < np.count_nonzero(self._aim) / 2)

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
        if not self._is_over:
            for pay in self._pays():
                costs, goal = most_gain(prices, position, pay)
                if goal is not None:
                    self._aim_at(goal)
                    return way_up(costs, goal)
            if blocked is not None:
                return None
            self.finish()
        return None if self.home is None else way_down(costs_from(prices, self.home), position)

    def arrive(self) -> None:
        """Give up what can still not be seen from here; at home, be done."""
        if self._is_over:
            self.is_done = True
        self.put_off()

    def put_off(self) -> None:
        """Give up the frontier that it was going to."""
        self._given_up |= disc(self._given_up.shape, cell_centre(*self._at), GIVEN_UP_M)

    def finish(self) -> None:
        """Explore no more: go home, or end here."""
        self._is_over = True
        self.is_done = self.home is None

    def _pays(self) -> Iterator[NDArray[np.float32]]:
        """What each known cell pays, in cells of way, for a look from there: more for a longer frontier.

        Where no way leads to those, short ones count on which a robot can stand: one may be a narrow way out.
        """
        frontier = self._frontier((slice(None), slice(None)))
        length = cv2.boxFilter(frontier.astype(np.float32), -1, (AROUND_CELLS, AROUND_CELLS), normalize=False)
        for counts in (frontier & (length >= LEAST_FRONTIER_CELLS), frontier & np.isfinite(self.ways.prices)):
            pay = np.where(counts, length, np.float32(0.0))
            for _ in range(LOOK_FROM_CELLS):  # over known cells only, never through a wall
                pay = np.where(self.seen.is_free, cv2.dilate(pay, EIGHT), np.float32(0.0))
            yield pay

    def _aim_at(self, goal: tuple[int, int]) -> None:
        self._at, reach = goal, LOOK_FROM_CELLS + 3
        rows, cols = (slice(max(0, k - reach), k + reach + 1) for k in goal)
        self._window = rows, cols
        self._aim = self._frontier(self._window)

    def _frontier(self, window: tuple[slice, slice]) -> NDArray[np.bool_]:
        """The cells of a window that are seen free, beside unknown ones, and not given up.

        Unknown is what is neither seen free nor beside a hit: between two beams that met a wall there is wall.
        """
        free = self.seen.since[window] >= 0
        wall = cv2.dilate(np.ascontiguousarray(self.seen.is_hit[window]).view(np.uint8), EIGHT) > 0
        beside_unknown = cv2.dilate((~free & ~wall).view(np.uint8), FOUR) > 0
        frontier: NDArray[np.bool_] = free & beside_unknown & ~self._given_up[window]
        return frontier
