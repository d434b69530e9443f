"""A building of a family made from a seed: drawn, furnished, doors shut, turned, and proved to be drivable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
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
from sim.floorplans.visits import Furniture, Leaves, change, shut
from sim.floorplans.warehouse import Warehouse
from sim.motion.driving import DriveField, drivable, standing_spot
from sim.world import Prism, World

DRAFTS = 20
_KINDS = (Office, Apartment, Warehouse, Loop, Hospital, Polygonal, TwoWing, Round, Hall, Clutter)
FAMILIES: Mapping[str, type[WorldSpec]] = MappingProxyType({kind.family: kind for kind in _KINDS})


def families() -> dict[str, str]:
    """Return the families of buildings by name, each with one line about it."""
    return {name: (kind.__doc__ or "").partition("\n")[0].rstrip(".") for name, kind in FAMILIES.items()}


def make_world(spec: WorldSpec, seed: int) -> World:
    """Make a building of a family from a seed; a robot can drive between all its rooms during both visits.

    Raises
    ------
    SimulationError
        If no such building was found, which a changed spec cures, or shapely is missing.
    """
    try:
        import shapely  # noqa: F401 - said here, once, rather than by every draft
    except ImportError as error:
        raise SimulationError(f"making a building {missing('shapely')}") from error
    rng = np.random.default_rng(seed)
    complaint = ""
    for _ in range(DRAFTS):
        try:
            return replace(_draft(spec, rng), family=spec.family, seed=seed)
        except SimulationError as error:
            complaint = str(error)
    raise SimulationError(f"{DRAFTS} drafts of this {spec.family} came to nothing: {complaint}")


def _draft(spec: WorldSpec, rng: np.random.Generator) -> World:
    """Draw, furnish and turn one building, and thin its furniture out until a robot can drive through it."""
    from sim.floorplans.furnishing import Furnisher

    pen = Pen(rng, size_m=spec.size_m, wall_m=spec.wall_m, door_m=spec.door_m, glass=spec.glass)
    spec.draw(pen)
    leaves = shut(pen, spec.shut, may_differ=spec.changed > 0)
    furnisher = Furnisher(pen)
    for room in pen.rooms:
        if room.name not in pen.bare:
            pen.pieces += furnisher.furnish(room, spec.furniture)
    furniture = change(pen.pieces, spec.changed, furnisher.another, rng)
    yaw = rng.uniform(0.0, math.tau) if spec.yaw_deg == "random" else math.radians(spec.yaw_deg)
    while True:
        world = _built(pen, leaves, furniture).turned(yaw)
        spots = _spots(world)
        cut_off = [room.name for room, spot in zip(world.rooms, spots, strict=True) if spot is None]
        if not cut_off:
            placed = zip(world.rooms, spots, strict=True)
            return replace(world, rooms=tuple(replace(room, spot=spot) for room, spot in placed if spot is not None))
        rooms = _in_the_way(pen, leaves, furniture, set(cut_off))
        if not rooms:
            raise SimulationError(f"a robot cannot reach {cut_off[0]!r}; wider doors (door_m) may help")
        furniture = furniture.thinned(rooms)


def _in_the_way(pen: Pen, leaves: Leaves, furniture: Furniture, cut_off: set[str]) -> list[str]:
    """The furnished rooms where furniture stands in the way most likely: those on both sides of the cut come first."""
    ways = [*pen.joints, *(door.joins for door in (*pen.openings, *leaves.doors) if door.is_open)]
    beside = {name for joins in ways if len(cut_off & set(joins)) == 1 for name in joins}
    for names in (beside, cut_off, {room.name for room in pen.rooms}):
        if rooms := sorted(name for name in names if furniture.stands_in(name)):
            return rooms
    return []


def _built(pen: Pen, leaves: Leaves, furniture: Furniture) -> World:
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


def _spots(world: World) -> list[NDArray[np.float64] | None]:
    """Where a robot can stand in each room during both visits, and drive to from all others."""
    fields = [drivable(world.at_visit(visit)) for visit in ((0, 1) if any(world.visits) else (0,))]
    both = DriveField(
        np.minimum.reduce([field.clearance for field in fields]),
        np.logical_and.reduce([field.is_drivable for field in fields]),
    )
    return [standing_spot(both, room) for room in world.rooms]
