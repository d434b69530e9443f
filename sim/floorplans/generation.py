"""Generation of buildings from a seed: drawn, furnished, doors shut, turned, and checked to be drivable."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from rectmerge.extras import missing
from sim.floorplans.apartment import Apartment
from sim.floorplans.clutter import Clutter
from sim.floorplans.drafting import Pen
from sim.floorplans.hall import Hall
from sim.floorplans.hospital import Hospital
from sim.floorplans.loop import Loop
from sim.floorplans.office import Office
from sim.floorplans.pieces import Piece
from sim.floorplans.polygonal import Polygonal
from sim.floorplans.round import Round
from sim.floorplans.spec import WorldSpec
from sim.floorplans.two_wing import TwoWing
from sim.floorplans.visits import Furniture, Leaves, change_furniture, shut_doors
from sim.floorplans.warehouse import Warehouse
from sim.motion.driving import DriveField, find_standing_spot, make_drive_field
from sim.world import Prism, World

DRAFTS = 20
Drafted = TypeVar("Drafted")
_KINDS = (Office, Apartment, Warehouse, Loop, Hospital, Polygonal, TwoWing, Round, Hall, Clutter)
FAMILIES: Mapping[str, type[WorldSpec]] = MappingProxyType({kind.family: kind for kind in _KINDS})


def families() -> dict[str, str]:
    """Return the families of buildings by name, each with a line of description."""
    return {name: (kind.__doc__ or "").partition("\n")[0].rstrip(".") for name, kind in FAMILIES.items()}


def make_world(spec: WorldSpec, seed: int, *, storey: int = 0) -> World:
    """Make a storey of a building from a seed, in which a robot can drive between all rooms during both visits.

    Parameters
    ----------
    spec
        Settings of the building.
    seed
        Seed of the building.
    storey
        Storeys of one seed have the same outer walls and corridors, and other rooms, doors and furniture; where
        `spec.yaw_deg` is random, each is turned by itself.

    Raises
    ------
    InputError
        If a building of the family has no storeys but the first.
    SimulationError
        If no draft gives such a building, or shapely is missing.
    """
    if storey and not spec.has_storeys:
        raise InputError(f"storey must be 0 for a building of family {spec.family}, got {storey}")
    try:
        import shapely  # noqa: F401 - checked here, once, rather than in every draft
    except ImportError as error:
        raise SimulationError(f"making a building {missing('shapely')}") from error
    rng = np.random.default_rng(seed)
    start, world = _first_success(lambda: (copy.deepcopy(rng), _draft(spec, rng)), spec)
    if storey:
        rooms_rng = np.random.default_rng((seed, storey))
        world = _first_success(lambda: _draft(spec, copy.deepcopy(start), rooms_rng), spec)
    return replace(world, family=spec.family, seed=seed)


def _first_success(draft: Callable[[], Drafted], spec: WorldSpec) -> Drafted:
    reason = ""
    for _ in range(DRAFTS):
        try:
            return draft()
        except SimulationError as error:
            reason = str(error)
    raise SimulationError(f"{DRAFTS} drafts of this {spec.family} failed: {reason}")


def _draft(spec: WorldSpec, rng: np.random.Generator, rooms_rng: np.random.Generator | None = None) -> World:
    """Draw, furnish and turn one building, and thin its furniture out until a robot can drive through it."""
    from sim.floorplans.furnishing import Furnisher

    pen = Pen(rng, size_m=spec.size_m, wall_m=spec.wall_m, door_m=spec.door_m, glass=spec.glass, rooms_rng=rooms_rng)
    spec.draw(pen)
    rng = pen.rng
    leaves = shut_doors(pen, spec.shut, may_differ=spec.changed > 0)
    furnisher = Furnisher(pen)
    for room in pen.rooms:
        if room.name not in pen.bare:
            pen.pieces += furnisher.furnish(room, spec.furniture)
    furniture = change_furniture(pen.pieces, spec.changed, furnisher.find_another_place, rng)
    yaw = rng.uniform(0.0, math.tau) if spec.yaw_deg == "random" else math.radians(spec.yaw_deg)
    while True:
        world = _build_world(pen, leaves, furniture).turned(yaw)
        spots = _standing_spots(world)
        cut_off = [room.name for room, spot in zip(world.rooms, spots, strict=True) if spot is None]
        if not cut_off:
            placed = zip(world.rooms, spots, strict=True)
            return replace(world, rooms=tuple(replace(room, spot=spot) for room, spot in placed if spot is not None))
        rooms = _rooms_in_the_way(pen, leaves, furniture, set(cut_off))
        if not rooms:
            raise SimulationError(f"a robot cannot reach {cut_off[0]!r}; wider doors (door_m) may help")
        furniture = furniture.thinned(rooms)


def _rooms_in_the_way(pen: Pen, leaves: Leaves, furniture: Furniture, cut_off: set[str]) -> list[str]:
    """Return the furnished rooms where furniture most likely blocks the path: first those on both sides of the cut."""
    ways = [*pen.joints, *(door.joins for door in (*pen.openings, *leaves.doors) if door.is_open)]
    at_cut = {name for joins in ways if len(cut_off & set(joins)) == 1 for name in joins}
    for names in (at_cut, cut_off, {room.name for room in pen.rooms}):
        if rooms := sorted(name for name in names if furniture.stands_in(name)):
            return rooms
    return []


def _build_world(pen: Pen, leaves: Leaves, furniture: Furniture) -> World:
    return World(
        size=pen.size_m,
        walls=(*pen.walls, *leaves.always),
        furniture=(*pen.fixtures, *_parts(furniture.always)),
        glass=tuple(pen.glass),
        visits=(
            (*leaves.once[0], *_parts(furniture.once[0])),
            (*leaves.once[1], *_parts(furniture.once[1])),
        ),
        rooms=tuple(pen.rooms),
        doors=leaves.doors,
        floor=tuple(pen.floor),
    )


def _parts(pieces: tuple[Piece, ...]) -> tuple[Prism, ...]:
    return tuple(part for piece in pieces for part in piece.put.parts)


def _standing_spots(world: World) -> list[NDArray[np.float64] | None]:
    """Return a spot in each room that a robot can reach from all others during both visits, or None."""
    fields = [make_drive_field(world.at_visit(visit)) for visit in ((0, 1) if any(world.visits) else (0,))]
    both = DriveField(
        np.minimum.reduce([field.clearance for field in fields]),
        np.logical_and.reduce([field.is_drivable for field in fields]),
    )
    return [find_standing_spot(both, room) for room in world.rooms]
