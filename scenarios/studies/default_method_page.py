"""Page of the default method's results: the table, missed pairs, the confidence, and the ablations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from scenarios.scoring.markdown import markdown
from scenarios.scoring.row import Row, versions_line
from scenarios.scoring.statistics import clustered_rate
from scenarios.studies.accuracy import count, grouped, is_right, median_error_px
from scenarios.studies.trust import answered

CONFIDENCE_BINS = (0.0, 0.05, 0.35, 0.65, 0.9, 0.99, 1.0)
COVERAGES = (0.25, 0.5, 0.75, 0.9, 1.0)


@dataclass(frozen=True, slots=True)
class GroupLine:
    """Line of the table: the groups that it sums up, and the aim of the method there."""

    name: str
    groups: tuple[str, ...]
    aim: str


LINES = (
    GroupLine("hand-held, as they are", ("real_maps sensor",), ""),
    GroupLine("hand-held, turned and rescaled", ("real_maps sensor-hard",), ""),
    GroupLine("**both**", ("real_maps sensor", "real_maps sensor-hard"), ">= 94 %, none wrong"),
    GroupLine("floor plans, as they are", ("real_maps layout",), ""),
    GroupLine("floor plans, turned and rescaled", ("real_maps layout-hard",), ""),
    GroupLine("**both**", ("real_maps layout", "real_maps layout-hard"), ">= 90 %, none wrong"),
    GroupLine("**other places**, turned and rescaled", ("real_maps negative",), "none accepted"),
    GroupLine("**laser**, required", ("real_lasers laser",), "all, e <= 0.4"),
    GroupLine("laser, optional (overlap < 0.15)", ("real_lasers laser, optional",), ""),
    GroupLine("**laser, other places**", ("real_lasers negative",), "none accepted"),
    GroupLine("smoke, noise 0", ("smoke, noise 0",), ""),
    GroupLine("smoke, noise 1", ("smoke, noise 1",), ""),
    GroupLine("headline, noise 0", ("headline, noise 0",), ""),
    GroupLine("headline, even noise 1", ("headline, noise cells-1",), ""),
    GroupLine(
        "**smoke and headline**",
        ("smoke, noise 0", "smoke, noise 1", "headline, noise 0", "headline, noise cells-1"),
        ">= 98 %",
    ),
)


def page(rows: Sequence[Row], ablated: Mapping[str, Sequence[Row]], machine: Mapping[str, Any]) -> str:
    """Return the page in Markdown: the table, missed pairs, the confidence, the ablations, and provenance."""
    parts = [
        INTRODUCTION,
        results_table(grouped(rows)),
        TABLE_EXPLAINED,
        versions_line(rows),
        "## Every pair that was not answered as it should be\n",
        MISSED_EXPLAINED,
        missed_table(rows),
        "## What the confidence is worth\n",
        CONFIDENCE_EXPLAINED,
        brier_line(rows),
        reliability_table(rows),
        risk_table(rows),
        "## What each stage earns\n",
        ABLATION_EXPLAINED,
        ablation_table(ablated),
        "## How it was made\n",
        _provenance(machine),
    ]
    return "\n".join(parts)


def results_table(groups: Mapping[str, Sequence[Row]]) -> str:
    """Count every group, and the sums of groups with an aim; a group without a line gets its own."""
    named = {group for line in LINES for group in line.groups}
    lines = [*LINES, *(GroupLine(name, (name,), "") for name in groups if name not in named)]
    cells = []
    for line in lines:
        rows = [row for group in line.groups for row in groups.get(group, ())]
        if rows:
            cells.append((line.name, *_counts(rows), line.aim))
    heads = ("what", "n", "right", "right and accepted", "wrong and accepted", "ambiguous", "rejected", "failed")
    return markdown((*heads, "median e", "median s", "aim"), cells)


def _counts(rows: Sequence[Row]) -> list[str]:
    counts, places = count(rows), [row["place"] for row in rows]
    right, wrong = (
        clustered_rate([row["outcome"] == name for row in rows], places)
        for name in ("right-accepted", "wrong-accepted")
    )
    is_related = any(row["stratum"] != "unrelated" for row in rows)
    return [
        str(len(rows)),
        str(counts["right"]) if is_related else "-",
        str(right) if is_related else "-",
        str(counts["wrong-accepted"]) if is_related else str(wrong),
        *(str(counts[name]) for name in ("ambiguous", "rejected", "failed")),
        *(_number(value) for value in (median_error_px(rows), _median_seconds(rows))),
    ]


def missed_table(rows: Sequence[Row]) -> str:
    """List the pairs of one place that are not right and accepted, and those of two that are accepted or fail."""
    refusals = ("rejected", "ambiguous-without-truth")
    missed = [
        row
        for row in rows
        if not (row["outcome"] == "right-accepted" or (row["stratum"] == "unrelated" and row["outcome"] in refusals))
    ]
    cells = [
        (
            f"{row['suite']} {row['pair_id']}",
            row["stratum"],
            row["outcome"],
            "right" if is_right(row) else "wrong",
            _number(row["errors"] and row["errors"]["e_px"]),
            _number(row["overlap"]),
            _number(row["confidence"]),
            row["reason"],
        )
        for row in missed
    ]
    heads = ("pair", "stratum", "outcome", "best candidate", "its e", "true overlap", "confidence", "reason")
    return markdown(heads, cells) if cells else "None.\n"


def brier_line(rows: Sequence[Row]) -> str:
    """Return the Brier score, and that of a constant confidence: the share of right answers."""
    confidence, right = answered(rows)
    if not len(right):
        return "No answers.\n"
    unrelated = sum(row["stratum"] == "unrelated" for row in rows)
    return (
        f"{len(right)} answers, {unrelated} of them to pairs of two places; {int(right.sum())} best candidates are "
        f"right. Brier score {np.mean((confidence - right) ** 2):.4f}; always saying their share would score "
        f"{right.mean() * (1 - right.mean()):.4f}.\n"
    )


def reliability_table(rows: Sequence[Row]) -> str:
    """Compare the confidence with the share that was right, by bins of confidence."""
    confidence, right = answered(rows)
    cells = []
    for low, high in pairwise(CONFIDENCE_BINS):
        held = (confidence >= low) & ((confidence < high) | (high == 1.0))
        if held.any():
            shown = (f"{confidence[held].mean():.3f}", f"{right[held].mean():.3f}")
            cells.append((f"{low:g} to {high:g}", str(int(held.sum())), *shown))
    return markdown(("confidence", "n", "mean confidence", "share right"), cells)


def risk_table(rows: Sequence[Row]) -> str:
    """Tabulate the share of wrong answers among the most confident, by coverage."""
    cells = []
    for coverage in COVERAGES:
        line = [f"{100 * coverage:.0f} %"]
        for kept in (rows, [row for row in rows if row["stratum"] != "unrelated"]):
            confidence, right = answered(kept)
            first = np.argsort(-confidence, kind="stable")[: math.ceil(coverage * len(right))]
            line.append(f"{int((1 - right[first]).sum())} of {len(first)}")
        cells.append(line)
    return markdown(("most confident", "wrong, all answers", "wrong, pairs of one place only"), cells)


def ablation_table(ablated: Mapping[str, Sequence[Row]]) -> str:
    """Count each ablation's rows, the hand-held maps apart from the laser maps."""
    cells = []
    for name, rows in ablated.items():
        required = [row for row in rows if row["stratum"] == "required"]
        parts = [[row for row in required if row["suite"] == suite] for suite in ("real_maps", "real_lasers")]
        counts = [count(part) for part in parts]
        cells.append(
            (
                name,
                *(f"{group['right-accepted']} of {len(part)}" for group, part in zip(counts, parts, strict=True)),
                str(sum(group["right"] for group in counts)),
                str(count(rows)["wrong-accepted"]),
                *(_number(median_error_px(part)) for part in parts),
                _number(_median_seconds(rows)),
            )
        )
    heads = ("off", "hand-held", "laser", "right at all", "wrong and accepted", "e hand-held", "e laser", "s")
    return markdown(heads, cells)


def _median_seconds(rows: Sequence[Row]) -> float | None:
    """Return the median processor time of an answer, on one core."""
    seconds = [row["seconds"]["cpu"] for row in rows if row["seconds"] and row["seconds"]["cpu"] is not None]
    return float(np.median(seconds)) if seconds else None


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _provenance(machine: Mapping[str, Any]) -> str:
    packages = ", ".join(f"{package} {version}" for package, version in machine["packages"].items())
    return f"""    rectbench results MAPS -o results/robust --force

MAPS is the folder that holds the data sets `real_maps` and `real_lasers`. The rows themselves go to `run/` in the
folder of this file and are not kept. Seed 0.

{machine["processor"]}, {machine["cores"]} cores, {machine["system"]}, Python {machine["python"]}, {packages}; commit
{machine["commit"] or "unknown"}.
"""


INTRODUCTION = """# What the default method, `robust`, reaches

One configuration, its defaults, for every row; no resolution is known to it, so the scale is searched from 0.5 to 2.
Real maps by their data sets' names and pair ids; they are not part of this repository. The method's constants were
chosen on these real maps and on simulated offices: places it has not seen are the test that counts, and are not here.
"""
TABLE_EXPLAINED = """k of n with the share and its 95 % interval, by bootstrap over places. *Right*: the best candidate
is, whatever the verdict: error below max(1 % of A's extent, 2 x the truth's residual), 5 degrees and 5 % of scale.
*Median e*: error of the best candidate over the control points in cells of A, all n. *Median s*: processor time of one
answer, warm, one thread, maps already read. *Aim*: what the method is held to. Hand-held maps bend: no similarity is
exact on them. Other places: 72 pairs, each turned by any angle and rescaled by 0.6 to 1.6 three times.
"""
MISSED_EXPLAINED = """Pairs of one place that are not right and accepted, and pairs of two places that are accepted or
failed; a pair of two places called ambiguous is not merged, and counts in the table above only.
"""
CONFIDENCE_EXPLAINED = """The confidence is the probability that the best candidate is right. It was fitted to
simulated pairs and to real ones, these among them: what it is worth on others is what `rectbench calibrate` prints for
the places that it leaves out, and in [trust](../trust/README.md). All rows of the table above.
"""
ABLATION_EXPLAINED = """On the turned and rescaled hand-held pairs and floor plans (33 + 15) and all laser pairs (15
required, 1 optional, 6 of other places): right and accepted, right whatever the verdict, wrong and accepted (of all),
median e and processor time. One thing is off or smaller at a time; the verdict's model is not fitted anew, so what
changes a likelihood may cost verdicts rather than answers. The simulated pairs and the 216 of other places are not run
here.
"""
