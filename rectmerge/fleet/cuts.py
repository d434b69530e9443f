"""Cuts of a component that few pairs cross: each map from all others, and both sides of every bridge."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rectmerge.fleet.bridges import find_bridges
from rectmerge.fleet.evidence import Pair


def weak_cuts(members: Sequence[int], edges: Sequence[Pair], reference: int) -> list[tuple[int, ...]]:
    """List the weak cuts of a component, each by its side without the reference.

    Parameters
    ----------
    members
        Maps of the component, two or more.
    edges
        Agreeing pairs.
    reference
        One of the maps.
    """
    cuts = {_side({index}, members, reference) for index in members}
    for bridge in find_bridges(edges):
        cuts.add(_side(reached({bridge[0]}, [edge for edge in edges if edge != bridge]), members, reference))
    return sorted(tuple(sorted(side)) for side in cuts if side)


def reached(start: Iterable[int], edges: Sequence[Pair]) -> set[int]:
    """Return the maps that a chain of pairs connects with some maps, and these."""
    found, grows = set(start), True
    while grows:
        beside = {index for edge in edges if not found.isdisjoint(edge) for index in edge}
        grows = not beside <= found
        found |= beside
    return found


def _side(side: Iterable[int], members: Sequence[int], reference: int) -> frozenset[int]:
    """Return the side of a cut without the reference."""
    chosen = frozenset(side)
    return frozenset(members) - chosen if reference in chosen else chosen
