"""Path tracking: a robot steers to a point of its path a little ahead (pure pursuit)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.driving import CELL_M

LOOK_AHEAD_M = 0.45


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering:
    """Path-tracking controller of a differential drive: turn towards a point ahead, slow down where it lies aside.

    Parameters
    ----------
    speed_m_s, turn_rad_s
        Limits of the forward speed and of the rate of turn.
    """

    speed_m_s: float = 0.8
    turn_rad_s: float = 2.0

    def command(self, pose: NDArray[np.float64], target: NDArray[np.float64]) -> tuple[float, float]:
        """Return the forward speed (m/s) and rate of turn (rad/s) that lead from a pose (x, y, yaw) to a point."""
        away = target - pose[:2]
        error = math.remainder(math.atan2(away[1], away[0]) - pose[2], math.tau)
        turn = max(-self.turn_rad_s, min(self.turn_rad_s, 3.0 * error))
        ahead = max(0.0, math.cos(error)) ** 3 if abs(error) < 1.2 else 0.0
        return self.speed_m_s * ahead * min(1.0, float(np.hypot(*away)) / 0.4 + 0.2), turn


def look_ahead(
    path: NDArray[np.float64], position: NDArray[np.float64], reached: int
) -> tuple[NDArray[np.float64], int]:
    """Return the point of a path to steer to, and the index of the point of the path nearest to the position.

    `reached` is the last such index: the search covers the next two metres only and never goes back.
    """
    window = path[reached : reached + 20]
    nearest = reached + int(np.argmin(np.hypot(window[:, 0] - position[0], window[:, 1] - position[1])))
    aim = min(len(path) - 1, nearest + max(1, round(LOOK_AHEAD_M / CELL_M)))
    return path[aim], nearest


class PathFollower:
    """Progress of a robot along a path."""

    def __init__(self, path: NDArray[np.float64]) -> None:
        self._path, self._at = path, 0

    @property
    def end(self) -> NDArray[np.float64]:
        """Last waypoint, (2,)."""
        last: NDArray[np.float64] = self._path[-1]
        return last

    @property
    def rest(self) -> NDArray[np.float64]:
        """Waypoints ahead, (N, 2)."""
        return self._path[self._at :]

    def target(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the point to steer to from a position."""
        target, self._at = look_ahead(self._path, position, self._at)
        return target
