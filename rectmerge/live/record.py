"""Record of a replay, ``follow.json``: what would have been published, and when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rectmerge.live.replay import Step

SCHEMA = "rectmerge.follow/1"


def to_json_dict(steps: Sequence[Step]) -> dict[str, Any]:
    """Return the content of ``follow.json``: transforms and statuses at the end, and all events with their times."""
    last = steps[-1].published
    unit = last.grid.unit if last.grid else "m"
    transforms = [
        {"robot": robot, "x": place.tx, "y": place.ty, "yaw": place.angle, "scale": place.scale, "unit": unit}
        for robot, place in last.placements.items()
    ]
    statuses = {
        robot: {
            "level": status.level,
            "verdict": status.verdict,
            "confidence": status.confidence,
            "message": status.message,
        }
        for robot, status in last.statuses.items()
    }
    events = [{"time_s": step.time_s} | event.as_dict() for step in steps for event in step.published.events]
    return {
        "schema": SCHEMA,
        "reference": last.reference,
        "duration_s": steps[-1].time_s,
        "transforms": transforms,
        "robots": statuses,
        "events": events,
    }
