"""Differences between the visits of the two robots: changed furniture and shut doors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.floorplans.drafting import HEIGHT_M, Pen
from sim.floorplans.pieces import Piece
from sim.world import Door, Prism, bar

LEAF_M = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class Furniture:
    """Furniture of a building: the pieces of both visits, and those of one visit only."""

    always: tuple[Piece, ...]
    once: tuple[tuple[Piece, ...], tuple[Piece, ...]] = ((), ())

    def thinned(self, rooms: Iterable[str]) -> Furniture:
        """Remove every third piece of some rooms, and the only piece where there is one."""
        chosen = set(rooms)
        return Furniture(
            _thinned(self.always, chosen), (_thinned(self.once[0], chosen), _thinned(self.once[1], chosen))
        )

    def stands_in(self, room: str) -> bool:
        """Return whether there is any furniture in a room."""
        return any(piece.room == room for group in (self.always, *self.once) for piece in group)


def change_furniture(
    pieces: Sequence[Piece], share: float, find_another_place: Callable[[Piece], Piece | None], rng: np.random.Generator
) -> Furniture:
    """Move, remove or add a share of the pieces between the visits.

    Parameters
    ----------
    pieces
        All pieces.
    share
        Share of the pieces that change.
    find_another_place
        Finds another place for a piece, or None.
    rng
        Source of the choice of pieces and of their changes.
    """
    chosen = set(rng.permutation(len(pieces))[: round(share * len(pieces))].tolist())
    only: tuple[list[Piece], list[Piece]] = ([], [])
    for k in sorted(chosen):
        visit = int(rng.integers(2))
        only[visit].append(pieces[k])
        moved = find_another_place(pieces[k]) if rng.random() < 0.5 else None
        if moved:
            only[1 - visit].append(moved)
    always = tuple(piece for k, piece in enumerate(pieces) if k not in chosen)
    return Furniture(always, (tuple(only[0]), tuple(only[1])))


@dataclass(frozen=True, slots=True, eq=False)
class Leaves:
    """Leaves of the shut doors of a building, always or during one visit only, and all its doors."""

    doors: tuple[Door, ...]
    always: tuple[Prism, ...]
    once: tuple[tuple[Prism, ...], tuple[Prism, ...]]


def shut_doors(pen: Pen, share: float, *, may_differ: bool) -> Leaves:
    """Shut a share of the doors, but none that a room needs to be reachable.

    Parameters
    ----------
    pen
        The plan.
    share
        Share of its doors.
    may_differ
        Whether some are shut during one visit only.
    """
    rng, doors = pen.rng, list(pen.doors)
    wanted = int(share * len(doors) + rng.random())
    open_ways = pen.joints + [door.joins for door in pen.openings] + [door.joins for door in doors]
    always: list[Prism] = []
    once: tuple[list[Prism], list[Prism]] = ([], [])
    for k in rng.permutation(len(doors)):
        left = open_ways.copy()
        left.remove(doors[k].joins)
        if wanted == len(always) + len(once[0]) + len(once[1]):
            break
        if _is_connected([room.name for room in pen.rooms], left):
            open_ways, doors[k] = left, replace(doors[k], is_open=False)
            leaf = Prism(bar(doors[k].ends[0], doors[k].ends[1], LEAF_M), HEIGHT_M)
            (once[int(rng.integers(2))] if may_differ and rng.random() < 0.5 else always).append(leaf)
    return Leaves(tuple(doors), tuple(always), (tuple(once[0]), tuple(once[1])))


def _is_connected(names: Sequence[str], ways: Sequence[tuple[str, str]]) -> bool:
    group = {name: name for name in names}
    for first, second in ways:
        old, new = group[second], group[first]
        group = {name: new if at == old else at for name, at in group.items()}
    return len(set(group.values())) == 1


def _thinned(pieces: tuple[Piece, ...], rooms: set[str]) -> tuple[Piece, ...]:
    """Drop the first of every three pieces of some rooms."""
    count = dict.fromkeys(rooms, 0)
    kept = []
    for piece in pieces:
        if piece.room in count:
            count[piece.room] += 1
        if piece.room not in count or count[piece.room] % 3 != 1:
            kept.append(piece)
    return tuple(kept)
