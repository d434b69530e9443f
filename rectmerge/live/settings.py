"""Settings of the node, with the description and the bounds of each as ROS parameters have them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.live.robot_names import PATTERN, robot_of
from rectmerge.methods import DEFAULT_METHOD


def _setting(default: Any, about: str, bounds: tuple[float, float] | None = None) -> Any:
    metadata = {"about": about, "bounds": bounds}
    if callable(default):
        return field(default_factory=default, metadata=metadata)
    return field(default=default, metadata=metadata)


def _memory_file() -> str:
    return str(Path(os.environ.get("ROS_HOME") or Path.home() / ".ros") / "rectmerge.json")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of the node.

    Raises
    ------
    InputError
        If one cannot be used; the message names it.
    """

    topics: str = _setting(PATTERN, "Topics of the robots' maps, with ROBOT in place of the robot's name.")
    robots: tuple[str, ...] = _setting((), "Names of the robots; empty takes every robot whose topic appears.")
    reference: str = _setting("", "Robot whose map frame is kept; empty takes the first that sends a map.")
    rate: float = _setting(1.0, "Most merges a second, by the machine's clock.", (0.01, 100.0))
    accepts: int = _setting(2, "Answers that must agree, on maps that changed between them.", (1, 10))
    method: str = _setting(DEFAULT_METHOD, "Method of alignment; see `rectmerge methods`.")
    merged_topic: str = _setting("/map", "Topic of the merged map.")
    frame: str = _setting("map", "Frame of the merged map, and parent of the transforms.")
    memory_file: str = _setting(_memory_file, "File that keeps the placements across restarts; empty keeps none.")

    def __post_init__(self) -> None:
        robot_of("/", self.topics)
        for each in fields(self):
            value, bounds = getattr(self, each.name), each.metadata["bounds"]
            if bounds is not None and not bounds[0] <= value <= bounds[1]:
                raise InputError(f"{each.name} must be {bounds[0]:g} to {bounds[1]:g}, got {value:g}")
        if not self.frame.strip() or self.frame.startswith("/"):
            raise InputError(f"frame must name a frame without a leading slash, got {self.frame!r}")
        if robot_of(self.merged_topic, self.topics) is not None:
            raise InputError(f"merged_topic {self.merged_topic} is one of the robots' topics, {self.topics}")

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Settings:
        """Return the settings of parameters by name."""
        return cls(**{**values, "robots": tuple(values["robots"])})

    def topic_of(self, robot: str) -> str:
        """Return the topic of a robot's map."""
        return self.topics.replace("ROBOT", robot)
