"""Accuracy of the default method: its real and simulated pairs, counts, and regressions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.dataset.reader import RowSource, open_dataset
from scenarios.pairs.pair import PairSource
from scenarios.pairs.random_rescale import RescaledSource
from scenarios.scoring.row import Row, is_best_right
from scenarios.scoring.score import FAILURES
from scenarios.suites.suite import load_suite

RESCALES = 3  # turns and rescales of every unrelated pair of the hand-held maps
SUITES = ("smoke", "headline")
FEWER_RIGHT_AT_MOST = 1  # pairs
ERROR_GROWTH_AT_MOST = 1.2


def real_tasks(maps: str | Path) -> dict[str, list[PairSource]]:
    """Return the sources of real pairs, by name.

    Parameters
    ----------
    maps
        The folder that holds the data sets ``real_maps`` and ``real_lasers``.

    Returns
    -------
    dict
        "real_maps", its related pairs; "negatives", its unrelated ones, each under three seeded turns and rescales;
        "real_lasers", all of it.

    Raises
    ------
    DatasetError
        If a data set does not exist, or does not keep the layout.
    """
    hand_held, lasers = (open_dataset(Path(maps) / name) for name in ("real_maps", "real_lasers"))
    unrelated = [source for source in hand_held if isinstance(source, RowSource) and not source.related]
    negatives = [
        RescaledSource(source=source, seed=(number, turn), mark=f"turn{turn}")
        for number, source in enumerate(unrelated)
        for turn in range(1, RESCALES + 1)
    ]
    related = [source for source in hand_held if source not in unrelated]
    return {"real_maps": related, "negatives": [*negatives], "real_lasers": lasers}


def simulated_tasks(names: Sequence[str] = SUITES) -> dict[str, list[PairSource]]:
    """Return the sources of simulated pairs, by the suite's name."""
    return {name: [*load_suite(name).sources()] for name in names}


def group_of(row: Row) -> str:
    """Return the group of a row, a line of the table.

    A row whose pair could not be made has nothing but its suite's name, and counts under that.
    """
    info = row["info"] or {}
    if "variant" in info:
        name: str = info["variant"]
        stratum = "" if name == "negative" or row["stratum"] == "required" else f", {row['stratum']}"
        return f"{row['suite']} {name}{stratum}"
    return f"{row['suite']}, noise {info['noise']}" if "noise" in info else f"{row['suite']}, pair not made"


def grouped(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return rows by group, in the order in which they were run."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(group_of(row), []).append(row)
    return groups


def count(rows: Sequence[Row]) -> Counter[str]:
    """Count outcomes of rows, and under "right" those whose best candidate is right, whatever the verdict."""
    counts = Counter(str(row["outcome"]) for row in rows)
    counts["right"] = sum(is_right(row) for row in rows)
    counts["ambiguous"] = sum(counts[name] for name in ("ambiguous-with-truth", "ambiguous-without-truth"))
    counts["failed"] = sum(counts[name] for name in FAILURES)
    return counts


def is_right(row: Row) -> bool:
    """Return whether the best candidate is right; none of an unrelated pair is."""
    return row["stratum"] != "unrelated" and is_best_right(row)


def median_error_px(rows: Sequence[Row]) -> float | None:
    """Return the median error of the best candidates in cells of A; a row without candidate counts as worst.

    None where there is no truth to measure against, or half of the rows have no candidate.
    """
    errors = [row["errors"]["e_px"] if row["errors"] else math.inf for row in rows]
    median = float(np.median(errors)) if errors else math.inf
    return median if math.isfinite(median) else None


def baseline_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the baseline of later runs: plain data for a small JSON file."""
    lines = {}
    for name, group in grouped(rows).items():
        counts = count(group)
        lines[name] = {
            "n": len(group),
            "right_accepted": counts["right-accepted"],
            "wrong_accepted": counts["wrong-accepted"],
            "median_e_px": median_error_px(group),
        }
    return {"schema": "rectmerge.accuracy/1", "groups": lines}


def regressions(rows: Sequence[Row], baseline: Mapping[str, Any]) -> list[str]:
    """Return the regressions of rows against a baseline, one line each.

    A group may lose one right and accepted pair, may accept nothing that is wrong, and its median error may grow by
    20 %. A group that the baseline lacks, or has with another number of pairs, is a regression too.
    """
    worse = []
    for name, new in baseline_of(rows)["groups"].items():
        old = baseline["groups"].get(name)
        if old is None or old["n"] != new["n"]:
            worse.append(f"{name}: {new['n']} pairs, the baseline has {old['n'] if old else 'none'}")
            continue
        if new["right_accepted"] < old["right_accepted"] - FEWER_RIGHT_AT_MOST:
            worse.append(f"{name}: {new['right_accepted']} right and accepted, was {old['right_accepted']}")
        if new["wrong_accepted"] > 0:
            worse.append(f"{name}: {new['wrong_accepted']} wrong and accepted")
        limit = math.inf if old["median_e_px"] is None else ERROR_GROWTH_AT_MOST * old["median_e_px"]
        if (math.inf if new["median_e_px"] is None else new["median_e_px"]) > limit:
            worse.append(f"{name}: median error {new['median_e_px']} cells, was {old['median_e_px']:.3f}")
    return worse
