"""Scores of an entrant on a fleet: every pair whose truth is known, as the entrant lays it, and maps joined wrongly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rectmerge.similarity import Similarity
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import known_extent
from scenarios.scoring.score import RIGHT, UNRELATED_BELOW, Errors, grade, measure_errors
from scenarios.studies.fleet_entrants import Joined, Pair

PairOutcome = Literal["right", "nearly", "wrong", "apart"]


def score_fleet(joined: Joined, places: Mapping[str, str], truth: Mapping[Pair, MapPair]) -> dict[str, Any]:
    """Score what an entrant joined, as plain data for JSON.

    Parameters
    ----------
    joined
        The entrant's answer.
    places
        The building of each map.
    truth
        All pairs; those of two buildings, or with less than 0.05 in common, have no outcome.

    Returns
    -------
    dict
        `pairs`: of each related pair its overlap, `outcome` in the common frame, `alone`, the verdict of the pair where
        it was asked, `ratio`, the error in the common frame over that of its own answer where both are right, and
        `scale_error`, the absolute logarithm of the scale over the true one, where it is right. `wrong_maps`: see
        `wrong_maps`. `left_out`, `asked`, `maps`: numbers. `named`: whether every wrong map hangs on a bridge that
        the answer names. `seconds`: CPU time beside the pairs'.
    """
    component = {name: index for index, names in enumerate(joined.components) for name in names}
    related = {key: pair for key, pair in truth.items() if pair.related and (pair.overlap or 0.0) >= UNRELATED_BELOW}
    rows = {key: _score_pair(key, pair, joined, component) for key, pair in related.items()}
    outcomes: dict[Pair, PairOutcome] = {key: row["outcome"] for key, row in rows.items()}
    wrong = [name for names in joined.components for name in wrong_maps(names, places, outcomes)]
    return {
        "maps": len(places),
        "asked": len(joined.answers),
        "left_out": len(places) - len(component),
        "wrong_maps": len(wrong),
        "named": bool(wrong) and _are_named(joined, places, outcomes),
        "pairs": list(rows.values()),
        "seconds": joined.seconds,
    }


def wrong_maps(names: Sequence[str], places: Mapping[str, str], outcomes: Mapping[Pair, PairOutcome]) -> list[str]:
    """List the maps that lie wrong in a component: all but its largest group of maps that lie right to each other.

    A map with no outcome about any of the others is taken to lie right among maps of its own building.
    """
    inside = {pair: outcome for pair, outcome in outcomes.items() if set(pair) <= set(names)}
    groups = _grouped(names, [pair for pair, outcome in inside.items() if outcome in ("right", "nearly")])
    largest = max(groups, key=len)
    place = places[next(iter(largest))]
    off = {name for pair, outcome in inside.items() if outcome == "wrong" for name in pair}
    return [name for name in names if name not in largest and (places[name] != place or name in off)]


def _are_named(joined: Joined, places: Mapping[str, str], outcomes: Mapping[Pair, PairOutcome]) -> bool:
    """Return whether without the bridges that an answer names nothing is joined wrongly."""
    kept = [pair for pair in joined.used if pair not in set(joined.bridges)]
    names = [name for group in joined.components for name in group]
    return not any(wrong_maps(list(group), places, outcomes) for group in _grouped(names, kept))


def _grouped(names: Sequence[str], pairs: Sequence[Pair]) -> list[set[str]]:
    """Group names that pairs connect."""
    group = {name: {name} for name in names}
    for a, b in pairs:
        if group[a] is not group[b]:
            together = group[a] | group[b]
            group |= dict.fromkeys(together, together)
    return list({id(members): members for members in group.values()}.values())


def _score_pair(key: Pair, pair: MapPair, joined: Joined, component: Mapping[str, int]) -> dict[str, Any]:
    """Score one related pair."""
    a, b = key
    answer = joined.answers.get(key)
    row: dict[str, Any] = {
        "overlap": pair.overlap,
        "outcome": "apart",
        "alone": None if answer is None else answer.verdict,
        "ratio": None,
        "scale_error": None,
    }
    if a not in component or component[a] != component.get(b):
        return row
    found = joined.pixels[a].inverse() @ joined.pixels[b]
    errors, own_error = measure_errors(found, pair), None
    row["outcome"] = _outcome(errors, pair)
    if answer is not None and answer.pixels is not None:
        own = measure_errors(answer.pixels, pair)
        own_error = own.e_px if _outcome(own, pair) == "right" else None
    if row["outcome"] == "right":
        row["scale_error"] = _scale_error(found, pair)
        row["ratio"] = errors.e_px / own_error if own_error else None
    return row


def _outcome(errors: Errors, pair: MapPair) -> PairOutcome:
    graded = grade(errors, (pair.residual_px or 0.0) / known_extent(pair.a))
    if graded in RIGHT:
        return "right"
    return "nearly" if graded == "coarse" else "wrong"


def _scale_error(found: Similarity, pair: MapPair) -> float:
    assert pair.pixels is not None
    return abs(math.log(found.scale / pair.pixels.scale))
