"""Buildings of every family, made once for all tests."""

from __future__ import annotations

import functools

from sim.floorplans import FAMILIES, make_world
from sim.world import World

PLAIN = {"yaw_deg": 0.0, "glass": 0.0, "shut": 0.0, "changed": 0.0}


@functools.cache
def usual(family: str, seed: int) -> World:
    """Make a building of a family with all its defaults."""
    return make_world(FAMILIES[family](), seed)


@functools.cache
def plain(family: str, seed: int) -> World:
    """Make an upright building with open doors, no glass and one state."""
    return make_world(FAMILIES[family](**PLAIN), seed)
