"""Confidence in the placements of a component, by its weak cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rectmerge.fleet.cuts import weak_cuts
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
    certain = dict.fromkeys(members, 1.0)
    for side in weak_cuts(members, edges, reference):
        log_odds = joining.cut_log_odds([index for index in members if index not in side], side)
        probability = 1 / (1 + math.exp(-min(max(log_odds, -MAX_LOG_ODDS), MAX_LOG_ODDS)))
        for index in side:
            certain[index] *= probability
    return certain
