"""Missions of two maps that are unrelated but look alike.

other-building    B explores another building of the same family, with corridors as wide as A's
no-shared-room    one building; the robots stay so far apart that their maps have less than 0.05 in common
other-floor       B explores another building with the outer walls of A's, within 5 cm, the same turn and other rooms
other-storey      B explores another storey of A's building: the same outer walls, corridors and turn, and other rooms
mirrored          one building and one mission, and map B is flipped left to right: no similarity is true
blank-halls       two halls of different size, empty: no pillars, no furniture, no other rooms
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.suites.spec import Scenario
from sim.floorplans import Hall, WorldSpec, make_world
from sim.floorplans.splitting import width
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog, cut_to_overlap
from sim.world import World

SAME_WIDTH_M = 0.1  # tolerance of the widths of corridors
SAME_SHELL_M = 0.05  # tolerance of the positions of outer walls
MOST_SHARED = 0.05  # overlap of maps that share nothing
MAX_BUILDINGS, MAX_MISSIONS = 40, 4  # attempts
SeedFor = Callable[[str], int]  # a seed for a purpose


def unrelated_log(scenario: Scenario, seed: SeedFor) -> MissionLog:
    """Run the missions of an unrelated pair, and join A of the one with B of the other.

    Raises
    ------
    SimulationError
        If a mission fails, or no attempt gives a pair of the kind.
    """
    if scenario.kind == "no-shared-room":
        return _far_apart(scenario, seed)
    world = make_world(_spec_of(scenario, scenario.world), seed("world"))
    log = run_mission(world, scenario.mission, seed("mission"))
    if scenario.kind == "mirrored":
        return log
    other = run_mission(_other(world, scenario, seed), scenario.mission, seed("other mission"))
    return replace(log, b=other.b, discarded=log.discarded + other.discarded, whole=None)


def corridor_m(world: World) -> float | None:
    """Return the median width of a building's corridors, metres; None where it has none."""
    widths = [width(room.outline) for room in world.rooms if "corridor" in room.name]
    return float(np.median(widths)) if widths else None


def shell(world: World) -> NDArray[np.float64]:
    """Return the corners (2, 2) of the box around all rooms, metres: the thickness of outer walls counts."""
    corners = np.concatenate([room.outline for room in world.rooms])
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _far_apart(scenario: Scenario, seed: SeedFor) -> MissionLog:
    """Cut one mission so that the maps share nothing, as measured without noise by true poses."""
    world = make_world(scenario.world, seed("world"))
    failures = []
    for k in range(MAX_MISSIONS):
        try:
            log = cut_to_overlap(run_mission(world, scenario.mission, seed(f"mission {k}")), 0.0)
        except SimulationError as error:
            failures.append(str(error))
            continue
        shared = make_pair(log, MapSpec(), MapSpec(), 0).overlap
        if shared is None or shared < MOST_SHARED:
            return log
        failures.append(f"the maps share {shared:.2f}")
    raise SimulationError(f"no mission without a shared room in {MAX_MISSIONS} tries: {'; '.join(failures)}")


def _other(world: World, scenario: Scenario, seed: SeedFor) -> World:
    """Make the building of map B: the first that the kind allows."""
    spec = _spec_of(scenario, scenario.other or scenario.world)
    if scenario.kind == "other-storey":
        return make_world(spec, seed("world"), storey=1)
    for k in range(MAX_BUILDINGS):
        other = make_world(spec, seed(f"other world {k}"))
        if scenario.kind == "other-floor":
            is_alike = bool(np.abs(shell(world) - shell(other)).max() <= SAME_SHELL_M)
        else:
            wide, other_wide = corridor_m(world), corridor_m(other)
            is_alike = wide is None or other_wide is None or abs(wide - other_wide) <= SAME_WIDTH_M
        if is_alike:
            return other
    feature = "outer walls like" if scenario.kind == "other-floor" else "corridors as wide as"
    raise SimulationError(f"none of {MAX_BUILDINGS} other buildings has {feature} the first")


def _spec_of(scenario: Scenario, world: WorldSpec) -> WorldSpec:
    """Return the building without features that the kind of pair excludes."""
    if scenario.kind in ("other-floor", "other-storey"):
        return replace(world, yaw_deg=0.0)
    if scenario.kind == "blank-halls" and isinstance(world, Hall):
        return replace(world, missing=1.0, side_rooms=0, furniture=0.0, glass=0.0, shut=0.0, changed=0.0)
    return world
