"""Trust in the default method's verdict: a page from runs of `trust`, `repetitive` and `standard`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from scenarios.bench.resume import read_machine
from scenarios.bench.run import read_rows
from scenarios.scoring.markdown import markdown
from scenarios.scoring.row import Row, versions_line
from scenarios.scoring.score import FAILURES
from scenarios.scoring.statistics import clustered_rate
from scenarios.studies.accuracy import is_right

METHOD = "robust"
BINS = 10  # of equal count, for the calibration error
IDENTIFIABLE = {"True": "yes", "False": "no"}
EXACT: tuple[tuple[str, Literal["e_px", "rotation_deg", "scale_pct"], bool], ...] = (
    ("e, cells of the coarser map", "e_px", True),
    ("rotation, degrees", "rotation_deg", False),
    ("scale, %", "scale_pct", False),
)
LOW = ((0.1, 0.2), (0.2, 0.3), (0.3, 1.01))  # overlaps


def write_page(runs: Sequence[Path], out: Path) -> None:
    """Write the page from finished runs.

    Raises
    ------
    InputError
        If a folder holds no run, or no row is of the method.
    """
    rows = [row for run in runs for row in read_rows(run) if row["method"] == METHOD]
    tested = [row for row in rows if (row["info"] or {}).get("split", "test") == "test"]
    if not tested:
        raise InputError(f"no rows of {METHOD} in the split test in {', '.join(map(str, runs))}")
    commits = {str(run): read_machine(run)["commit"] or "unknown" for run in runs}
    replace_file(out, page(tested, commits).encode())


def page(rows: Sequence[Row], commits: Mapping[str, str]) -> str:
    """Return the page; `commits` holds the commit of each run's folder."""
    parts = [
        INTRODUCTION,
        "    rectbench trust " + " ".join(commits) + " -o results/trust/README.md\n",
        "Runs: " + ", ".join(f"{run} by commit {commit}" for run, commit in commits.items()) + ".\n",
        versions_line(rows),
        "## Pairs of one place, by overlap\n\n" + OVERLAP_EXPLAINED,
        overlap_table([row for row in rows if row["suite"] == "trust"]),
        "## Exactness of rigid pairs\n\n" + EXACT_EXPLAINED,
        exactness_table([row for row in rows if row["suite"] == "trust"]),
        "## Rooms in rows\n\n" + REPETITIVE_EXPLAINED,
        repetitive_table([row for row in rows if row["suite"] == "repetitive"]),
        "## Pairs of two places\n",
        unrelated_table([row for row in rows if row["stratum"] == "unrelated"]),
        "## What the confidence is worth\n\n" + calibration_line(rows),
        reliability_table(rows),
        "## Every wrong answer that was accepted\n",
        wrong_table(rows),
    ]
    return "\n".join(parts)


def overlap_table(rows: Sequence[Row]) -> str:
    """Count outcomes of related pairs, by overlap and by identifiability."""
    cells = []
    for low, high in LOW:
        held = [row for row in rows if row["overlap"] is not None and low <= row["overlap"] < high]
        for name, part in (("identifiable", _identifiable(held)), ("not", _identifiable(held, False))):
            cells.append((f"{low:g} to {min(high, 1):g}", name, *_outcomes(part)))
    return markdown(("overlap", "exact maps", *OUTCOMES), cells)


def exactness_table(rows: Sequence[Row]) -> str:
    """Tabulate the errors of right answers to rigid pairs of overlap 0.35 and more."""
    rigid = [
        row
        for row in rows
        if (row["info"] or {}).get("pose_source") == "truth" and (row["overlap"] or 0) >= 0.35 and is_right(row)
    ]
    cells = []
    for name, key, coarser in EXACT:
        values = [errors[key] / (_coarseness(row) if coarser else 1.0) for row in rigid if (errors := row["errors"])]
        cells.append(
            (name, str(len(values)), *(f"{np.quantile(values, q):.3f}" if values else "-" for q in (0.5, 0.9)))
        )
    return markdown(("what", "n", "median", "90th percentile"), cells)


def repetitive_table(rows: Sequence[Row]) -> str:
    """Count outcomes of wards of equal rooms, by the offset of the rooms."""
    cells = []
    for name in sorted({row["pair_id"].rsplit("-", 2)[0] for row in rows}):
        part = [row for row in rows if row["pair_id"].rsplit("-", 2)[0] == name]
        for kind, rows_of_kind in (("identifiable", _identifiable(part)), ("not", _identifiable(part, False))):
            cells.append((name, kind, *_outcomes(rows_of_kind)))
    return markdown(("rooms", "exact maps", *OUTCOMES), cells)


def unrelated_table(rows: Sequence[Row]) -> str:
    """Count outcomes of unrelated pairs, by kind."""
    kinds = sorted({_kind(row) for row in rows})
    cells = []
    for kind in kinds:
        part = [row for row in rows if _kind(row) == kind]
        merged = [row["outcome"] == "wrong-accepted" for row in part]
        unsure = sum(str(row["verdict"]) == "ambiguous" for row in part)
        cells.append((kind, str(len(part)), str(sum(merged)), str(unsure), str(len(part) - sum(merged) - unsure)))
    return markdown(("kind", "n", "merged", "ambiguous", "rejected"), cells) if cells else "None in these runs.\n"


def calibration_line(rows: Sequence[Row]) -> str:
    """Return the Brier score and the expected calibration error as text, with the share of negatives."""
    confidence, right = answered(rows)
    unrelated = sum(row["stratum"] == "unrelated" for row in rows if row["verdict"])
    return (
        f"{len(right)} answers in the split test, {unrelated} of them to unrelated pairs; {right.mean():.2f} of the "
        f"best candidates are right. Brier score {np.mean((confidence - right) ** 2):.4f}; expected calibration "
        f"error in {BINS} bins of equal count {calibration_error(confidence, right):.4f}.\n"
    )


def calibration_error(confidence: NDArray[np.float64], right: NDArray[np.float64]) -> float:
    """Return the expected calibration error: the mean of |confidence - share right| over bins of equal count.

    Examples
    --------
    >>> calibration_error(np.full(10, 0.5), np.array([0.0, 1.0] * 5)) < 0.51
    True
    >>> calibration_error(np.ones(10), np.zeros(10))
    1.0
    """
    order = np.argsort(confidence, kind="stable")
    bins = [part for part in np.array_split(order, BINS) if len(part)]
    return float(sum(len(part) * abs(confidence[part].mean() - right[part].mean()) for part in bins) / len(order))


def reliability_table(rows: Sequence[Row]) -> str:
    """Compare the confidence with the share that is right in each of the bins."""
    confidence, right = answered(rows)
    cells = []
    for part in np.array_split(np.argsort(confidence, kind="stable"), BINS):
        if len(part):
            ends = f"{confidence[part].min():.3f} to {confidence[part].max():.3f}"
            cells.append((ends, str(len(part)), f"{confidence[part].mean():.3f}", f"{right[part].mean():.3f}"))
    return markdown(("confidence", "n", "mean confidence", "share right"), cells)


def answered(rows: Sequence[Row]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the confidence of rows with a verdict, and 1.0 where the best candidate is right."""
    with_verdict = [row for row in rows if row["verdict"]]
    right = np.array([is_right(row) for row in with_verdict], np.float64)
    return np.array([row["confidence"] for row in with_verdict], np.float64), right


def wrong_table(rows: Sequence[Row]) -> str:
    """List the answers that were accepted though wrong."""
    wrong = [row for row in rows if row["outcome"] == "wrong-accepted"]
    cells = [
        (
            f"{row['suite']} {row['pair_id']}",
            str((row["info"] or {}).get("family", "-")),
            "-" if row["overlap"] is None else f"{row['overlap']:.2f}",
            IDENTIFIABLE.get(str((row["info"] or {}).get("identifiable")), "-"),
            f"{row['confidence']:.3f}",
        )
        for row in wrong
    ]
    heads = ("pair", "family", "true overlap", "identifiable", "confidence")
    return markdown(heads, cells) if cells else "None.\n"


OUTCOMES = ("n", "right and accepted", "wrong and accepted", "ambiguous with truth", "without", "rejected", "failed")


def _outcomes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Count the outcomes of rows, the right and accepted with their share and its interval by place."""
    names: Mapping[str, Callable[[Row], bool]] = {
        "wrong": lambda row: row["outcome"] == "wrong-accepted",
        "with": lambda row: row["outcome"] == "ambiguous-with-truth",
        "without": lambda row: row["outcome"] == "ambiguous-without-truth",
        "rejected": lambda row: row["outcome"] == "rejected",
        "failed": lambda row: row["outcome"] in FAILURES,
    }
    hits = [row["outcome"] == "right-accepted" for row in rows]
    rate = str(clustered_rate(hits, [row["place"] for row in rows])) if rows else "-"
    return str(len(rows)), rate, *(str(sum(map(is_so, rows))) for is_so in names.values())


def _identifiable(rows: Sequence[Row], wanted: bool = True) -> list[Row]:
    """Return the rows of identifiable pairs, or of the others; unknown counts as identifiable."""
    return [row for row in rows if (row["info"] or {}).get("identifiable", True) == wanted]


def _kind(row: Row) -> str:
    return str((row["info"] or {}).get("variant") or row["suite"])


def _coarseness(row: Row) -> float:
    """Return the cells of A per cell of the coarser map."""
    info: Mapping[str, Any] = row["info"] or {}
    return max(1.0, float(info["resolution_b"]) / float(info["resolution_a"]))


INTRODUCTION = """# What the verdict of `robust` is worth

Simulated pairs of the split *test*: other buildings than those the weights were fitted to, and two families (two-wing
and round) of which no training pair is. The run of `trust` is on buildings that took no part in any fit or choice, made
by `rectbench generate trust --seed 20261` (the fit has those of seed 7000, with even noise of the cells); that of
`standard` on the split test of `rectbench generate standard`; that of `repetitive` on the suite itself. One
configuration, the defaults; scale free between 0.5 and 2. This page is made by
"""
OVERLAP_EXPLAINED = """Noise 1, ten families, half of the pairs by true poses and half by the robots' own.
*Identifiable*: with the world known and no noise, the true placement beats every other by a margin
(`scenarios/suites/identifiability.py`); where it does not, as in rows of equal rooms, *ambiguous* is the right answer.
"""
EXACT_EXPLAINED = """True poses, overlap 0.35 and more, right answers whatever the verdict.
"""
REPETITIVE_EXPLAINED = """Wards of twelve rooms that are alike, standing off their places by up to 0, 0.15 or 0.5 m;
overlap 0.6, noise 0 and 1.
"""
