"""Settings of a mission: two robots, their exploration, and its end."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from rectmerge.errors import InputError
from sim.sensors.lidar import Lidar

USUAL_SHARE = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSpec:
    """Settings of one robot and of its exploration.

    Parameters
    ----------
    lidar
        Its scanner.
    speed_m_s
        Top speed.
    scan_hz
        Scans that are kept per simulated second, no more than the scanner makes; where `physics_hz` is no multiple of
        it, a little fewer.
    path
        "tour": from room to room, by a robot that knows the building; "frontier": to the border of the floor that it
        has seen (Yamauchi 1997), in buildings with and without rooms.
    share
        Share of the rooms that it tours, 0.7 unless given: A from one end of the building, B from the other. Not for
        frontiers, nor where the mission wants an overlap.
    closes_loop
        Whether it returns to its start in the end, and tours rooms in a round.

    Raises
    ------
    InputError
        If a value is out of range, or values exclude each other.
    """

    lidar: Lidar = field(default_factory=Lidar)
    speed_m_s: float = 0.9
    scan_hz: float = 4.0
    path: Literal["tour", "frontier"] = "tour"
    share: float | None = None
    closes_loop: bool = False

    def __post_init__(self) -> None:
        _require_within(self, speed_m_s=(0.1, 2.0), scan_hz=(0.5, 40.0), share=(0.0, 1.0))
        _require_one_of(self, path=("tour", "frontier"))
        if self.scan_hz > self.lidar.rate_hz:
            raise InputError(f"scan_hz must be at most the lidar's rate_hz, {self.lidar.rate_hz}, got {self.scan_hz}")
        if self.share is not None and self.path == "frontier":
            raise InputError("share is of the rooms of a tour: path = 'frontier' takes none")


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionSpec:
    """Settings of a mission of two robots.

    Parameters
    ----------
    a, b
        The robots, which may differ in everything.
    physics_hz
        Physics steps per simulated second.
    rays
        "pybullet": lasers meet what robots touch, by PyBullet's rays; "compiled": by a ray caster on the plan, the
        same to a millimetre or so and faster.
    max_seconds
        Simulated time after which a robot stops, wherever it is.
    coverage
        Share of the drivable floor at which each robot ends its exploration; None: it goes on as long as there is
        something to explore.
    overlap
        Wanted overlap of the finished maps, 0.1 to 1: robots start far apart for a small one, near for a large one,
        and the logs are cut where the maps have it, within 0.05. None: as it comes.
    tries
        Largest number of missions, from different starts, for a wanted overlap.

    Raises
    ------
    InputError
        If a value is out of range, or values exclude each other.
    """

    a: RobotSpec = field(default_factory=RobotSpec)
    b: RobotSpec = field(default_factory=RobotSpec)
    physics_hz: int = 60
    rays: Literal["pybullet", "compiled"] = "pybullet"
    max_seconds: float = 240.0
    coverage: float | None = None
    overlap: float | None = None
    tries: int = 4

    def __post_init__(self) -> None:
        _require_within(self, physics_hz=(30, 480), max_seconds=(5.0, 3600.0), coverage=(0.05, 1.0), overlap=(0.1, 1.0))
        _require_within(self, tries=(1, 20))
        _require_one_of(self, rays=("pybullet", "compiled"))
        if self.overlap is not None and not self.a.share is self.b.share is None:
            raise InputError("share and overlap exclude each other: with an overlap, tours go on until it is reached")


def _require_within(spec: object, **bounds: tuple[float, float]) -> None:
    for name, (low, high) in bounds.items():
        value = getattr(spec, name)
        if value is not None and not low <= value <= high:
            raise InputError(f"{name} must be {low} to {high}, got {value}")


def _require_one_of(spec: object, **choices: tuple[str, ...]) -> None:
    for name, allowed in choices.items():
        if getattr(spec, name) not in allowed:
            raise InputError(f"{name} must be one of {', '.join(map(repr, allowed))}, got {getattr(spec, name)!r}")
