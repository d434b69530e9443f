"""Furniture for the rooms of a plan: along the walls and free-standing, clear of doors and of itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import Point, Polygon

from sim.world import Prism, Room, World

WAY_M = 0.85  # left between two pieces, and around a free-standing one
DOOR_WAY_M = 0.9  # left around the middle of a door


def furnish(plan: World, density: float, rng: np.random.Generator) -> list[list[Prism]]:
    """Furnish every room of a plan but the corridor.

    Parameters
    ----------
    plan
        Walls, rooms and doors.
    density
        Mean pieces per 10 square metres.
    rng
        What to put where.

    Returns
    -------
    list of list of Prism
        The pieces of each room, in the order of `plan.rooms`.
    """
    return [[] if room.name == "corridor" else _furnish_room(plan, room, density, rng) for room in plan.rooms]


def _furnish_room(plan: World, room: Room, density: float, rng: np.random.Generator) -> list[Prism]:
    wanted = int(rng.poisson(density * room.area_m2 / 10))
    inside = Polygon(room.outline)
    doors = [Point(door.centre).buffer(max(DOOR_WAY_M, door.width_m / 2 + 0.3)) for door in plan.doors]
    pieces: list[Prism] = []
    for _ in range(wanted * 12):
        if len(pieces) >= wanted:
            break
        is_at_wall = rng.random() < 0.7
        piece = _at_wall(room, rng) if is_at_wall else _standing(room, rng)
        shape = Polygon(piece.outline)
        home = inside.buffer(0.02) if is_at_wall else inside.buffer(-WAY_M)
        others = (Polygon(other.outline) for other in pieces)
        if (
            home.contains(shape)
            and not any(map(shape.intersects, doors))
            and all(shape.distance(o) > WAY_M for o in others)
        ):
            pieces.append(piece)
    return pieces


def _at_wall(room: Room, rng: np.random.Generator) -> Prism:
    """A cupboard, shelf or desk with its back to a wall."""
    edges = np.roll(room.outline, -1, axis=0) - room.outline
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    k = int(rng.choice(len(edges), p=lengths / lengths.sum()))
    along = edges[k] / lengths[k]
    inward = np.array([-along[1], along[0]])
    size, depth = min(rng.uniform(0.7, 2.2), lengths[k] - 0.3), rng.uniform(0.4, 0.8)
    start = room.outline[k] + along * rng.uniform(0.1, max(0.11, lengths[k] - size - 0.1))
    corners = np.stack([start, start + along * size, start + along * size + inward * depth, start + inward * depth])
    return Prism(corners, float(rng.choice([0.75, 1.2, 1.9])))


def _standing(room: Room, rng: np.random.Generator) -> Prism:
    """A table, along the room's longest wall, or a round column."""
    lo, hi = room.outline.min(axis=0), room.outline.max(axis=0)
    centre = lo + (hi - lo) * rng.uniform(0.25, 0.75, 2)
    if rng.random() < 0.3:
        return Prism(centre + rng.uniform(0.18, 0.3) * _circle(12), 2.5)
    edges = np.roll(room.outline, -1, axis=0) - room.outline
    along = edges[int(np.argmax(np.hypot(edges[:, 0], edges[:, 1])))]
    along = along / np.hypot(*along)
    half_x, half_y = rng.uniform(0.5, 1.0), rng.uniform(0.35, 0.6)
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [half_x, half_y]
    return Prism(centre + signs @ np.stack([along, [-along[1], along[0]]]), 0.75)


def _circle(corners: int) -> NDArray[np.float64]:
    angle = np.arange(corners) * (2 * np.pi / corners)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
