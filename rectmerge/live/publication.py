"""Publication of one time: the merged map, the place of each robot's map on it, and the reason where it has none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rectmerge.analysis.shared_area import measure_shared_area
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity
from rectmerge.transfer.transform import Transform

Level = Literal["ok", "warn", "error"]


@dataclass(frozen=True, slots=True)
class RobotStatus:
    """Status of one robot.

    Parameters
    ----------
    level
        "ok" where its map is in the merged one, "warn" where it is not yet, "error" where it sends no usable map.
    message
        Reason in words.
    verdict
        "accepted", "pending" or "left out"; empty where its map was not compared.
    confidence
        Probability that the placement is right, 0..1; None where there is none.
    """

    level: Level
    message: str
    verdict: str = ""
    confidence: float | None = None


@dataclass(frozen=True, slots=True)
class Event:
    """Change of what is published.

    Parameters
    ----------
    robot, reference
        The robot whose map joined, moved or was taken out, and the robot whose frame is kept.
    change
        "joined", "moved", "taken out".
    reason
        In words.
    confidence
        Of the answer that made the change, 0..1; None where there is none.
    """

    robot: str
    reference: str
    change: str
    reason: str
    confidence: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "robot": self.robot,
            "reference": self.reference,
            "event": self.change,
            "reason": self.reason,
            "confidence": self.confidence,
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Publication:
    """State of the live merger after a step.

    Parameters
    ----------
    reference
        Robot whose map frame is kept; empty while there is no map.
    grid
        Merged map in that frame, or the reference's own map while nothing is sure; None while there is none.
    placements
        From the map frame of each robot in the merged map to the reference's.
    maps
        Newest map of each robot.
    statuses
        Status of every robot.
    events
        Changes made by this step.
    """

    reference: str
    grid: OccupancyGrid | None
    placements: Mapping[str, Similarity]
    maps: Mapping[str, OccupancyGrid]
    statuses: Mapping[str, RobotStatus]
    events: Sequence[Event] = ()

    def transform(self, robot: str) -> Transform:
        """Return the placement of a robot in the merged map, for TF: without scale it fits the shared area best."""
        a, b, placement = self.maps[self.reference], self.maps[robot], self.placements[robot]
        shared = measure_shared_area(a, b, map_frame_to_pixels(placement, a, b))
        known = a.resolution is not None and b.resolution is not None
        resolutions = (a.cell_size, b.cell_size) if known else None
        return Transform(placement, shared, a.unit, resolutions)
