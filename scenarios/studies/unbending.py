"""Errors of real and simulated pairs before and after they are unbent: a page of tables."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rectmerge
from rectmerge.elastic.known_points import fit_to_points
from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.reader import RowSource, open_dataset
from scenarios.execution.executors import describe_machine
from scenarios.execution.files import require_place
from scenarios.pairs.pair import MapPair, PairSource
from scenarios.pairs.truth import rms
from scenarios.scoring.bends import CHANGE
from scenarios.scoring.markdown import markdown
from scenarios.scoring.row import VERSIONS_EXPLAINED
from scenarios.suites.suite import load_suite

DATASETS = ("real_maps", "real_lasers")
GROUPS = {  # by variant; lasers may have none
    "sensor-hard": "hand-held, turned and rescaled",
    "layout-hard": "floor plans, turned and rescaled",
    "laser": "rigid lasers",
    "negative": "other places, by force",
    "carried": "simulated, as people carry them",
    "bent": "simulated, by estimated poses",
    "rigid": "simulated, by true poses",
}
SUITE = "bent"  # of simulated pairs
MIN_POINTS = 100  # control points, from which the best bend is known
CARRIED = "drift"  # begins the variants whose maps are as people carry them
ERRORS = ("e_similarity", "e_best", "e_best_bend", "e_unbent")


@dataclass(frozen=True, slots=True, kw_only=True)
class UnbentPair:
    """A pair before and after it was unbent.

    Parameters
    ----------
    group
        A key of `GROUPS`.
    pair_id
        The pair's.
    accepted
        Whether the bend was accepted.
    reason
        Its reason.
    e_similarity, e_best, e_best_bend, e_unbent
        RMSE over the control points in cells of A: of the best candidate, of the least-squares similarity, of a smooth
        displacement through half of the points measured on the other half, and of the answer, which is bent where that
        was accepted. None where the pair is unrelated, or has too few points.
    double_walls_before, double_walls_after
        Share of the common walls that the merged map shows twice; None where the maps have none in common.
    seconds, align_seconds
        Wall time of unbending, and of the alignment before.
    """

    group: str
    pair_id: str
    accepted: bool
    reason: str
    e_similarity: float | None
    e_best: float | None
    e_best_bend: float | None
    e_unbent: float | None
    double_walls_before: float | None
    double_walls_after: float | None
    seconds: float
    align_seconds: float


def pair_sources(maps: str | Path) -> list[PairSource]:
    """Return the real pairs of the groups, in the data sets' order, and the missions of the suite.

    Raises
    ------
    DatasetError
        If a data set does not exist, or does not keep the layout.
    """
    rows = [row for name in DATASETS for row in open_dataset(Path(maps) / name) if isinstance(row, RowSource)]
    real = [row for row in rows if row.info.get("variant", "laser") in GROUPS]
    return [*real, *load_suite(SUITE).sources()]


def group_of(info: Mapping[str, Any]) -> str:
    """Return the group of a pair by the columns of its row."""
    if "pose_source" in info:
        if str(info.get("variant", "")).startswith(CARRIED):
            return "carried"
        return "rigid" if info["pose_source"] == "truth" else "bent"
    return str(info.get("variant", "laser"))


def measure(sources: Sequence[PairSource], on_done: Callable[[str], None]) -> Iterator[UnbentPair]:
    """Align and unbend pairs one by one; pairs without a candidate, or without truth for a mission, are left out."""
    for source in sources:
        for pair in source.pairs():
            if (measured := unbend_pair(group_of(pair.info), pair)) is not None:
                yield measured
        on_done(source.source_id)


def unbend_pair(group: str, pair: MapPair) -> UnbentPair | None:
    """Align a pair, unbend its best candidate and measure both on the control points; None without candidate."""
    started = time.perf_counter()
    alignment = rectmerge.align(pair.a, pair.b)
    align_seconds = time.perf_counter() - started
    if not alignment.candidates:
        return None
    pixels = alignment.candidates[0].pixels
    bend = rectmerge.unbend(pair.a, pair.b, pixels)
    walls_before, walls_after = bend.double_walls(pair.a, pair.b)
    before = after = best_bend = None
    if pair.control_points is not None:
        at_a, at_b = pair.control_points[:, :2], pair.control_points[:, 2:]
        after = before = rms(pixels.apply(at_b) - at_a)
        best_bend = best_bend_error(pixels.apply(at_b), at_a)
        if bend.warp is not None:
            after = rms(bend.warp.apply(at_b) - at_a)
    return UnbentPair(
        group=group,
        pair_id=pair.pair_id,
        accepted=bool(bend),
        reason=bend.reason,
        e_similarity=before,
        e_best=pair.residual_px,
        e_best_bend=best_bend,
        e_unbent=after,
        double_walls_before=walls_before,
        double_walls_after=walls_after,
        seconds=bend.seconds,
        align_seconds=align_seconds,
    )


def best_bend_error(points: NDArray[np.float64], targets: NDArray[np.float64]) -> float | None:
    """Return the error that a smooth displacement leaves: fitted to every other point, measured on the others.

    None where there are too few points to say.
    """
    if len(points) < MIN_POINTS:
        return None
    left = np.empty_like(points)
    for start in (0, 1):
        fitted, held = slice(start, None, 2), slice(1 - start, None, 2)
        left[held] = fit_to_points(points[fitted], targets[fitted]).apply(points[held]) - targets[held]
    return rms(left)


def write_unbending(maps: str | Path, output: Path, *, on_done: Callable[[str], None]) -> None:
    """Measure the pairs and write the page.

    Parameters
    ----------
    maps
        The folder that holds the data sets ``real_maps`` and ``real_lasers``.
    output
        The page, in Markdown.
    on_done
        Called with the id of each source.
    """
    require_place(output)
    pairs = list(measure(pair_sources(maps), on_done))
    replace_file(output, page(pairs, describe_machine()).encode())


def page(pairs: Sequence[UnbentPair], machine: Mapping[str, Any]) -> str:
    """Return the page."""
    groups = {name: [pair for pair in pairs if pair.group == name] for name in GROUPS}
    version = f"The suite `{SUITE}` is of version {load_suite(SUITE).version}. {VERSIONS_EXPLAINED}\n"
    parts = [INTRODUCTION, version, summary_table(groups), PROVENANCE.format(**{"commit": "unknown", **machine})]
    for name, members in groups.items():
        if members and name != "negative":
            parts += [f"## {GROUPS[name].capitalize()}\n", pair_table(members)]
    return "\n".join(parts)


def summary_table(groups: Mapping[str, Sequence[UnbentPair]]) -> str:
    """Return one line for each group: medians of the errors, and shares of pairs that changed."""
    errors = ["similarity", "best similarity", "best bend", "unbent"]
    heads = ["set", "n", "bent", *errors, "better", "worse", "double walls, %", "time"]
    lines = []
    for name, members in groups.items():
        if not members:
            continue
        count = len(members)
        change = [p.e_unbent / p.e_similarity for p in members if p.e_unbent is not None and p.e_similarity]
        better, worse = sum(c < 1 - CHANGE for c in change), sum(c > 1 + CHANGE for c in change)
        medians = [_median([getattr(p, key) for p in members]) for key in ERRORS]
        changed = [f"{better} ({better / count:.0%})", f"{worse}"] if change else ["-", "-"]
        ratio = np.median([p.seconds / p.align_seconds for p in members])
        bent = str(sum(p.accepted for p in members))
        lines.append([GROUPS[name], str(count), bent, *medians, *changed, _double_walls(members), f"{ratio:.2f}"])
    return markdown(heads, lines)


def _double_walls(pairs: Sequence[UnbentPair]) -> str:
    """Return the mean shares of double walls before and after, over the pairs that were bent."""
    bent = [
        (p.double_walls_before, p.double_walls_after)
        for p in pairs
        if p.accepted and p.double_walls_before is not None and p.double_walls_after is not None
    ]
    return " to ".join(f"{100 * share:.0f}" for share in np.mean(bent, axis=0)) if bent else "-"


def pair_table(pairs: Sequence[UnbentPair]) -> str:
    """Return one line for each pair."""
    heads = ["pair", "similarity", "best similarity", "best bend", "unbent", "reason"]
    lines = [[p.pair_id, *(_median([getattr(p, key)]) for key in ERRORS), p.reason] for p in pairs]
    return markdown(heads, lines)


def _median(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{np.median(known):.2f}" if known else "-"


INTRODUCTION = """# Maps unbent

Real and simulated pairs, aligned by the default method, and the best candidate unbent by `rm.unbend`, whatever the
verdict. Errors: RMSE over the control points in cells of A, medians over pairs; `rm.unbend` never sees the points. They
are hand-made on real maps; on simulated ones (the suite `bent`) each is placed by its scan's estimated poses in both
maps, and so a sample of the true bend. *Best similarity*: fitted to the points themselves, what no similarity can
undercut. *Best bend*: a smooth displacement fitted to every other point and measured on the others; what is left there
is of walls that a robot drew in two places. *Better*, *worse*: pairs whose error changes by more than 10 %. *Double
walls*: mean share of the common walls that the merged map shows twice, more than 2 cells apart, of the pairs that were
bent. *Time*: of `rm.unbend`, over that of `rm.align`. *Other places*: maps of two places, laid on each other by force;
none should be bent, nor should rigid maps. The thresholds of the test were chosen on these real pairs, and on other
missions like those that people carry: places it has not seen are the test that counts.
"""
PROVENANCE = """    rectbench unbending MAPS -o results/unbending/README.md

MAPS is the folder that holds the data sets `real_maps` and `real_lasers`, which are not part of this repository.
{processor}, {cores} cores, {system}, Python {python}; commit {commit}.
"""
