"""Furniture for the rooms of a plan: along the walls and free-standing, clear of doors and of itself."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from shapely.geometry import Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from sim.floorplans.drafting import Pen
from sim.floorplans.pieces import AT_WALL, STANDING, Model, Piece
from sim.floorplans.shapes import Points
from sim.world import Door, Room

DOOR_WAY_M = 0.9  # clear radius around the middle of a door
TRIES, MODELS = 8, 3  # places tried for a piece, and pieces tried for each that is wanted


class Furnisher:
    """Furnisher of the rooms of one plan.

    Parameters
    ----------
    pen
        The plan, with the gaps and angles of furniture.
    """

    def __init__(self, pen: Pen) -> None:
        self._rng, self._way_m, self._turned = pen.rng, pen.way_m, pen.turned
        self._spares = list(pen.spares)
        self._rooms = {room.name: room for room in pen.rooms}
        self._space = {
            room.name: Polygon(room.outline).buffer(-pen.inner_m / 2, join_style="mitre") for room in pen.rooms
        }
        self._doors = [_doorway(door) for door in (*pen.doors, *pen.openings)]
        self._blocks = [Polygon(outline) for outline in pen.blocks]
        self._pieces = {
            room.name: [Polygon(p.put.outline) for p in pen.pieces if p.room == room.name] for room in pen.rooms
        }

    def furnish(self, room: Room, density: float) -> Iterable[Piece]:
        """Place a random number of pieces in a room, `density` per 10 square metres on average."""
        wanted = int(self._rng.poisson(density * room.area_m2 / 10))
        placed = 0
        for _ in range(MODELS * wanted):
            if placed == wanted:
                return
            is_at_wall = self._rng.random() < 0.65
            makers = AT_WALL if is_at_wall else STANDING
            model = makers[int(self._rng.integers(len(makers)))](self._rng)
            if piece := self.place(room.name, model, is_at_wall=is_at_wall):
                placed += 1
                yield piece

    def find_another_place(self, piece: Piece) -> Piece | None:
        """Find another place in the room for a piece, clear of all others."""
        for k in self._rng.permutation(len(self._spares)):
            if self._spares[k].room == piece.room:
                return self._spares.pop(k)
        if piece.room not in self._rooms:
            return None
        return self.place(piece.room, piece.model, is_at_wall=bool(self._rng.random() < 0.5))

    def place(self, name: str, model: Model, *, is_at_wall: bool) -> Piece | None:
        """Find a place for a piece in a room; None where no try succeeds."""
        space = self._space[name]
        for _ in range(TRIES):
            turned = bool(self._rng.random() < self._turned)
            put = self._at_wall(name, model) if is_at_wall and not turned else self._standing(name, model, turned)
            shape = Polygon(put.outline)
            home = space.buffer(0.02) if is_at_wall else space.buffer(-self._way_m)
            if home.contains(shape) and self._is_clear(name, shape):
                self._pieces[name].append(shape)
                return Piece(name, model, put)
        return None

    def _is_clear(self, name: str, shape: BaseGeometry) -> bool:
        others = self._pieces[name] + self._blocks
        return not any(map(shape.intersects, self._doors)) and all(shape.distance(o) > self._way_m for o in others)

    def _at_wall(self, name: str, model: Model) -> Model:
        """Put a piece with its back to a wall, 0.1 m off the corner where possible."""
        corners = np.array(orient(self._space[name]).exterior.coords)
        edges = np.diff(corners, axis=0)
        lengths = np.hypot(edges[:, 0], edges[:, 1])
        wide = float(model.outline[:, 0].max())
        chances = np.where(lengths > min(wide, lengths.max() - 1e-9), lengths, 0.0)
        k = int(self._rng.choice(len(edges), p=chances / chances.sum()))
        along, room = edges[k] / lengths[k], lengths[k] - wide
        return model.placed(
            corners[k] + along * self._rng.uniform(min(0.1, max(room, 0.0) / 2), max(room, 0.01)), along
        )

    def _standing(self, name: str, model: Model, is_turned: bool) -> Model:
        """Put a piece in the middle of a room, along its longest wall or at any angle."""
        outline = self._rooms[name].outline
        edges = np.roll(outline, -1, axis=0) - outline
        along = edges[int(np.argmax(np.hypot(edges[:, 0], edges[:, 1])))]
        turn = math.atan2(along[1], along[0]) + (self._rng.uniform(0, math.tau) if is_turned else 0.0)
        low, high = outline.min(axis=0), outline.max(axis=0)
        return _centred(model, low + (high - low) * self._rng.uniform(0.1, 0.9, 2), turn)


def _centred(model: Model, middle: Points, turn: float) -> Model:
    along = np.array([math.cos(turn), math.sin(turn)])
    offset = model.outline.mean(axis=0) @ np.stack([along, [-along[1], along[0]]])
    return model.placed(middle - offset, along)


def _doorway(door: Door) -> BaseGeometry:
    return Point(door.centre).buffer(max(DOOR_WAY_M, door.width_m / 2 + 0.3))
