"""Reasons of a verdict: the measures that decided in one line, with a cause only where they show it, and a remedy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from rectmerge.alignment import Verdict
from rectmerge.analysis.overlap import Agreement
from rectmerge.hints import Guess, Hint
from rectmerge.robust.params import ReasonParams
from rectmerge.robust.verdict import Evidence


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFacts:
    """Facts of a map: free cells of its working grid, and the share of neighbouring known cells that differ."""

    free_cells: int
    roughness: float


def accepted(evidence: Evidence, agreement: Agreement, params: ReasonParams) -> str:
    """Say why a placement is accepted."""
    said = f"the walls of both maps agree over {agreement.overlap:.0%} of the smaller free area"
    if evidence.bend_log_odds:
        return f"{said}; they are bent against each other, and a bend holds where it was not fitted"
    return f"{said}; they are bent against each other" if _is_bent(evidence, params) else said


def without_outside(reason: str, name: str) -> str:
    """Add to a reason that the outside of a map was taken as unknown."""
    return f"{reason}; the white outside of map {name} was taken as unknown"


def not_accepted(
    verdict: Verdict, evidence: Evidence, agreement: Agreement, maps: Mapping[str, MapFacts], params: ReasonParams
) -> str:
    """Say why the best placement is not accepted: the first cause that the numbers show.

    Parameters
    ----------
    verdict
        "ambiguous" or "rejected".
    evidence, agreement
        Of the best placement.
    maps
        Facts of each map, by the name that people know it by ("A", "B").
    params
        Thresholds of the reasons.
    """
    if replace(evidence, is_at_limit=False).probability >= evidence.asked:
        return "the maps fit best at a scale beyond the bounds of the search: widen --scale, or check the resolutions"
    if replace(evidence, slack_cells=0.0).probability >= evidence.asked:
        return (
            f"the walls in common do not hold the placement: it can slide by {evidence.slack_cells:.0f} cells; map a "
            "corner or a crossing wall that both maps share"
        )
    return _fault_of_maps(maps, params) or _fault_of_placement(verdict, evidence, agreement, params)


def better_elsewhere(hint: Hint) -> str:
    """Say that another placement explains the walls better than one near the hint."""
    if isinstance(hint, Guess):
        return "the walls agree better far from the guess than near it: correct it, or leave it out"
    return "the walls agree better elsewhere: correct the placement, or leave it out and it is searched for"


def no_wall(name: str, free_cells: int, params: ReasonParams) -> str:
    """Say why a map without a wall beside its free space cannot be placed."""
    reason = f"map {name} has no wall beside free space"
    return f"{reason}: it shows too little free space" if free_cells < params.min_free_cells else reason


def _fault_of_maps(maps: Mapping[str, MapFacts], params: ReasonParams) -> str | None:
    for name, facts in maps.items():
        if facts.free_cells < params.min_free_cells:
            return f"map {name} shows too little free space: map at least a few rooms"
    for name, facts in maps.items():
        if facts.roughness >= params.max_roughness:
            return (
                f"map {name} is too noisy ({facts.roughness:.0%} of neighbouring cells differ): clean it, or map again"
            )
    return None


def _fault_of_placement(verdict: Verdict, evidence: Evidence, agreement: Agreement, params: ReasonParams) -> str:
    measured = f"overlap {agreement.overlap:.0%} of the smaller map, {agreement.conflict:.0%} of the walls contradicted"
    if evidence.likelihood > 0 and _is_bent(evidence, params):
        beside = evidence.agreement.near - evidence.agreement.matched
        return (
            f"{beside:.0%} of the walls lie beside each other, not on each other ({measured}): if the maps show one "
            "place, they are bent against each other too much for one similarity; close loops in the mapping, or merge "
            "smaller parts"
        )
    if verdict == "ambiguous":
        return _doubt(evidence, params)
    if evidence.likelihood <= 0 or agreement.conflict >= params.contradicted_share:
        how = (
            "no placement explains the walls better than chance" if evidence.likelihood <= 0 else "no placement agrees"
        )
        return f"{how} (the best: {measured}): these seem to be maps of different places"
    return (
        f"the best placement agrees too little to tell one place from two ({measured}): "
        "if both maps show one place, map more of what they share"
    )


def _doubt(evidence: Evidence, params: ReasonParams) -> str:
    """Say what keeps a placement that alone would be accepted from it."""
    behind = evidence.plausibility - math.log(params.far_behind)
    if max(evidence.rest_log_odds, evidence.mirror_log_odds) < behind:
        return (
            f"candidate 1 leads all others, but too little speaks for it ({evidence.probability:.0%}, where "
            f"{evidence.asked:.0%} is asked; overlap {evidence.agreement.overlap:.0%} of the smaller map): "
            "look at its overlay, or map more of what both maps share"
        )
    if evidence.rest_log_odds < behind:
        return (
            f"the mirror image of one map fits nearly as well, so that the walls may agree by chance (the best has "
            f"{evidence.probability:.0%}): map more of what both share"
        )
    cause = "the building repeats itself or is symmetric"
    if evidence.agreement.overlap < params.little_overlap:
        cause += f", or the overlap of {evidence.agreement.overlap:.0%} is too little to tell"
    return (
        f"more than one placement explains the walls (the best has {evidence.probability:.0%}): {cause}; look at "
        "the candidates, or map more of what tells the places apart"
    )


def _is_bent(evidence: Evidence, params: ReasonParams) -> bool:
    """Test whether the maps fit each other, but with much of the walls beside each other."""
    return (
        evidence.agreement.near - evidence.agreement.matched >= params.bent_share
        and evidence.support >= params.bent_support
    )
