"""Page of a study of fleets: tables by suite and kind of fleet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from scenarios.scoring.markdown import markdown
from scenarios.scoring.statistics import Rate, clustered_rate

SHARED_FROM = 0.3  # overlap, from which a pair should end right
Line = Mapping[str, Any]


def page(lines: Sequence[Line], about: Mapping[str, Any]) -> str:
    """Return the page of some fleets' lines; `about` tells command, machine and commit."""
    parts = [INTRODUCTION, PROVENANCE.format(**{"commit": "unknown", **about})]
    for suite in dict.fromkeys(str(line["suite"]) for line in lines):
        members = [line for line in lines if line["suite"] == suite]
        for group in dict.fromkeys(str(line["group"]) for line in members):
            fleets = [line for line in members if line["group"] == group]
            parts += [f"## {suite}, {group}: {len(fleets)} fleets of {_range_of_maps(fleets)} maps\n", _table(fleets)]
    return "\n".join(parts)


def _range_of_maps(fleets: Sequence[Line]) -> str:
    counts = sorted({score["maps"] for fleet in fleets for score in fleet["entrants"].values()})
    return str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"


def _table(fleets: Sequence[Line]) -> str:
    heads = [
        *("entrant", "right, o >= 0.3", "right, o < 0.3", "nearly", "wrong", "apart", "wrong fleets", "wrong maps"),
        *("left out", "ambiguous: right", "wrong", "open", "error", "scale", "asked / N", "s"),
    ]
    names = dict.fromkeys(name for fleet in fleets for name in fleet["entrants"])
    return markdown(heads, [_row(name, fleets) for name in names])


def _row(name: str, fleets: Sequence[Line]) -> list[str]:
    scores = [fleet["entrants"][name] for fleet in fleets if name in fleet["entrants"]]
    outcomes = [pair["outcome"] for score in scores for pair in score["pairs"]]
    unsure = [pair["outcome"] for score in scores for pair in score["pairs"] if pair["alone"] == "ambiguous"]
    ratios = [pair["ratio"] for score in scores for pair in score["pairs"] if pair["ratio"] is not None]
    scales = [pair["scale_error"] for score in scores for pair in score["pairs"] if pair["scale_error"] is not None]
    wrong = [score for score in scores if score["wrong_maps"]]
    named = sum(bool(score["named"]) for score in wrong)
    return [
        name,
        str(_right(fleets, name, is_shared=True)),
        str(_right(fleets, name, is_shared=False)),
        *(str(outcomes.count(outcome)) for outcome in ("nearly", "wrong", "apart")),
        f"{len(wrong)} ({named} named)" if wrong else "0",
        str(sum(score["wrong_maps"] for score in scores)),
        f"{sum(score['left_out'] for score in scores)} of {sum(score['maps'] for score in scores)}",
        f"{unsure.count('right')} of {len(unsure)}",
        str(unsure.count("wrong")),
        str(unsure.count("apart")),
        f"{np.exp(np.mean(np.log(np.maximum(ratios, 1e-6)))):.2f}" if ratios else "-",
        f"{100 * max(scales):.1f} %" if scales else "-",
        f"{np.mean([score['asked'] / score['maps'] for score in scores]):.1f}",
        f"{np.mean([score['seconds'] for score in scores]):.1f}",
    ]


def _right(fleets: Sequence[Line], name: str, *, is_shared: bool) -> Rate:
    """Return the rate of related pairs that end right, of large or of small overlap, clustered by fleet."""
    found = list(_hits(fleets, name, is_shared))
    return clustered_rate([hit for hit, _ in found], [fleet for _, fleet in found])


def _hits(fleets: Sequence[Line], name: str, is_shared: bool) -> Iterator[tuple[bool, str]]:
    for fleet in fleets:
        for pair in fleet["entrants"].get(name, {"pairs": ()})["pairs"]:
            if (pair["overlap"] >= SHARED_FROM) == is_shared:
                yield pair["outcome"] == "right", str(fleet["fleet_id"])


INTRODUCTION = """# Fleets

Simulated fleets: maps of one building and of a sibling building, mixed and unlabelled. *joint*: `rm.align_many`.
*tree*: what peers do, the accepted pairs, the most confident first, chained. *lied to*: a tenth of a fleet's pairs, at
random, gets a sure but wrong answer: the pair's own best wrong candidate, with log-odds of 7.

*right*: related pairs whose maps lie right to each other in the common frame, by the rule of the benchmark, of an
overlap o of 0.3 and more, and of 0.05 to 0.3, with 95 % intervals clustered by fleet. *nearly*, *wrong*, *apart*: the
other related pairs. *wrong fleets*: those with a map joined wrongly; *named*, where without the bridges that the answer
names there is none. *ambiguous*: related pairs that were asked and are ambiguous alone, and what became of them.
*error*: geometric mean, over pairs that are right both ways, of the error in the common frame over that of the pair's
own answer. *scale*: the largest error of a right pair's scale. *asked / N*: pairs asked by map. *s*: mean CPU time of a
fleet beside that of its pairs.
"""
PROVENANCE = """    {command}

{processor}, {cores} cores, {system}, Python {python}; commit {commit}.
"""
