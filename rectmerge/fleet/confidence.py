"""Confidence in the placements of a component, by its weakest cuts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from rectmerge.fleet.bridges import find_bridges
from rectmerge.fleet.evidence import Pair
from rectmerge.fleet.joining import Joining

MAX_LOG_ODDS = 30.0


def confidences(members: Sequence[int], reference: int, edges: Sequence[Pair], joining: Joining) -> dict[int, float]:
    """Return the probability that each map of a component lies right relative to the reference.

    It is the product over the cuts that part the two: the map from all others, the reference from all others, and both
    sides of every bridge between them. Other cuts have two agreeing pairs or more, and are taken as sure.

    Parameters
    ----------
    members
        Maps of the component.
    reference
        One of them.
    edges
        Agreeing pairs.
    joining
        Evidence and poses.
    """
    cuts = {_cut({index}, members, reference) for index in members}
    for bridge in find_bridges(edges):
        cuts.add(_cut(_reached(bridge[0], [edge for edge in edges if edge != bridge]), members, reference))
    certain = dict.fromkeys(members, 1.0)
    for side in sorted(cuts, key=sorted):
        rest = [index for index in members if index not in side]
        log_odds = joining.cut_log_odds(rest, sorted(side))
        probability = 1 / (1 + math.exp(-min(max(log_odds, -MAX_LOG_ODDS), MAX_LOG_ODDS)))
        for index in side:
            certain[index] *= probability
    return certain


def _cut(side: Iterable[int], members: Sequence[int], reference: int) -> frozenset[int]:
    """Return the side of a cut without the reference."""
    chosen = frozenset(side)
    return frozenset(members) - chosen if reference in chosen else chosen


def _reached(start: int, edges: Sequence[Pair]) -> set[int]:
    """Return the maps that a chain of pairs connects with one."""
    reached, grows = {start}, True
    while grows:
        beside = {index for edge in edges if not reached.isdisjoint(edge) for index in edge}
        grows = not beside <= reached
        reached |= beside
    return reached
