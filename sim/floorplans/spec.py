"""Settings of a building: the parameters that every family has."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal

from rectmerge.errors import InputError
from sim.floorplans.drafting import JAMB_M, Pen

NARROWEST_ROOM_M = 2.4


@dataclass(frozen=True, kw_only=True)  # without slots, so that `Office.family` is the name
class WorldSpec(ABC):
    """Settings of a building; each family adds parameters of its own.

    Parameters
    ----------
    size_m
        Outer size (x, y) in metres before the building is turned, 6 to 60 each way.
    furniture
        Mean pieces of furniture per 10 square metres of room, 0 to 5; fewer where they would stand in the way.
    wall_m
        Least and greatest thickness of inner walls, within 0.06 to 0.4 m; drawn once per building. Outer walls are up
        to twice as thick.
    door_m
        Least and greatest width of doors, within 0.7 to 2.4 m; drawn for every door. A robot gets through less than
        0.8 m only where the wall runs along the axes.
    yaw_deg
        Heading of the building, degrees counter-clockwise; "random" draws it from the whole circle.
    glass
        Share of the inner partitions that are glass.
    shut
        Share of the doors that are shut, as far as no room is cut off: none where every room has one door.
    changed
        Share of the furniture that is moved, removed or added between the visits of the two robots. Unless it is 0, one
        in two shut doors is shut during one visit only.

    Raises
    ------
    InputError
        If a value is out of range, or the rooms do not fit.
    """

    has_storeys: ClassVar[bool] = False  # whether `draw` chooses outer walls and corridors first, then `begin_rooms`
    family: str = field(default="", init=False)
    size_m: tuple[float, float] = (20.0, 13.0)
    furniture: float = 1.2
    wall_m: tuple[float, float] = (0.08, 0.3)
    door_m: tuple[float, float] = (0.8, 1.6)
    yaw_deg: float | Literal["random"] = "random"
    glass: float = 0.05
    shut: float = 0.1
    changed: float = 0.15

    def __post_init__(self) -> None:
        if not (len(self.size_m) == 2 and min(self.size_m) >= 6.0 and max(self.size_m) <= 60.0):
            raise InputError(f"size_m must be 6 to 60 metres each way, got {list(self.size_m)}")
        if not 0 <= self.furniture <= 5:
            raise InputError(f"furniture must be 0 to 5 pieces per 10 square metres, got {self.furniture}")
        require_range("wall_m", self.wall_m, 0.06, 0.4)
        require_range("door_m", self.door_m, 0.7, 2.4)
        for name in ("glass", "shut", "changed"):
            require_share(name, getattr(self, name))
        if self.yaw_deg != "random" and not _is_number(self.yaw_deg):
            raise InputError(f'yaw_deg must be a number of degrees or "random", got {self.yaw_deg!r}')
        self.check()

    @abstractmethod
    def check(self) -> None:
        """Refuse values of the parameters of the family, and rooms that do not fit."""

    @abstractmethod
    def draw(self, pen: Pen) -> None:
        """Draw one building of the family.

        Raises
        ------
        SimulationError
            If this draft fails; another may succeed.
        """

    @property
    def narrowest_m(self) -> float:
        """Least width of a room, between the middles of its walls."""
        return max(NARROWEST_ROOM_M, self.door_m[0] + 2 * JAMB_M + self.wall_m[1])

    @property
    def inside_m(self) -> tuple[float, float]:
        """Size between the middles of the outer walls, where these are thickest."""
        return self.size_m[0] - 3 * self.wall_m[1], self.size_m[1] - 3 * self.wall_m[1]

    def require_room(self, along: float, across: float, what: str) -> None:
        """Refuse a size that leaves less than `along` x `across` metres within the outer walls."""
        (x, y), doors = self.inside_m, f"doors from {self.door_m[0]} m and walls up to {self.wall_m[1]} m"
        if x < along or y < across:
            raise InputError(f"size_m: {what} with {doors} do not fit into {self.size_m[0]} x {self.size_m[1]} m")


def require_share(name: str, value: float) -> None:
    """Refuse a number that is not within 0 to 1."""
    if not 0 <= value <= 1:
        raise InputError(f"{name} must be a share from 0 to 1, got {value}")


def require_range(name: str, value: Sequence[float], least: float, most: float) -> None:
    """Refuse values that are not two ascending numbers within bounds."""
    if not (len(value) == 2 and least <= value[0] <= value[1] <= most):
        raise InputError(f"{name} must be two ascending numbers within {least} to {most} m, got {list(value)}")


def require_count(name: str, value: int, least: int, most: int) -> None:
    """Refuse a number out of bounds."""
    if not least <= value <= most:
        raise InputError(f"{name} must be {least} to {most}, got {value}")


def require_within(name: str, value: float, least: float, most: float) -> None:
    """Refuse metres out of bounds."""
    if not least <= value <= most:
        raise InputError(f"{name} must be {least} to {most} m, got {value}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
