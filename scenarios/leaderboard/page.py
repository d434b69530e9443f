"""Leaderboard in Markdown: a table for every suite and track, and the prediction of real results by simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from scenarios.leaderboard.plans import REAL
from scenarios.leaderboard.prediction import OVERLAPS, kendall_tau, matched_overlap, successes, tau_interval
from scenarios.report.difficulty import leaders, leaders_line, leaders_map
from scenarios.report.reading import TRACKS, Runs, TrackResults
from scenarios.report.standings import as_cells, standings
from scenarios.scoring.markdown import markdown
from scenarios.scoring.row import versions_line

COLUMNS = (
    "right and accepted",
    "area",
    "best right",
    "wrong",
    "false merges",
    "checked: right / wrong",
    "failed",
    "AURC",
    "e, cells",
    "CPU s",
)
PREDICTING = "standard"


def page(runs: Runs, reported: Mapping[str, str] | None = None, data_sets: Mapping[str, str] | None = None) -> str:
    """Return the page of finished runs.

    Parameters
    ----------
    runs
        Runs made here, and the rows of submissions.
    reported
        Status of each label that is of a submission.
    data_sets
        Id of the data set of each suite, where it is known.
    """
    statuses, ids = reported or {}, data_sets or {}
    parts = [INTRODUCTION]
    for track_results in runs.tracks:
        parts += [f"## {track_results.name}\n", _size(track_results, ids), leaderboard(track_results, statuses)]
        parts += difficulty(track_results)
    parts += [SUBMISSIONS_EXPLAINED] if statuses else []
    return "\n".join([*parts, "## Does simulation predict reality?\n", prediction(runs.tracks), _provenance(runs)])


def leaderboard(track_results: TrackResults, reported: Mapping[str, str]) -> str:
    """Return the table of one suite and track, with a column for who says so where not all of it was run here."""
    lines = [(line.label, as_cells(line)) for line in standings(track_results)]
    rows = [[label, *(cells[name][0] for name in COLUMNS)] for label, cells in lines]
    heads = ["method", *COLUMNS]
    if any(label in reported for label, _ in lines):
        heads.append("reported")
        rows = [[*row, reported.get(row[0], "run here")] for row in rows]
    return markdown(heads, rows)


def difficulty(track_results: TrackResults) -> list[str]:
    """Return the first methods of each box of a difficulty grid; nothing of other suites."""
    if not (first := leaders(track_results)):
        return []
    table = leaders_map(first)
    rows = [(name, *(cell.text for cell in cells)) for name, cells in table.lines]
    return [f"{FIRST_EXPLAINED}{leaders_line(first)}\n", markdown(("overlap", *table.columns), rows)]


def prediction(tracks: Sequence[TrackResults]) -> str:
    """Compare the ranking on simulated pairs with that on real ones, and success at equal overlap."""
    unknown_scale = [track_results for track_results in tracks if track_results.track == TRACKS[False]]
    simulated = [track_results for track_results in unknown_scale if track_results.suite == PREDICTING]
    real = [track_results for track_results in unknown_scale if track_results.suite in REAL]
    if not simulated or not real:
        return f"Unknown: this page holds no run of {PREDICTING}, or none of real pairs.\n"
    of_simulated, of_real = successes(simulated), successes(real)
    labels = [label for label in of_simulated if label in of_real]
    scores = [[rates[label].value or 0.0 for label in labels] for rates in (of_simulated, of_real)]
    low, high = tau_interval(simulated, real)
    tau = (
        f"Kendall's tau-b of the two rankings of {len(labels)} methods: **{kendall_tau(*scores):.2f}** "
        f"(95 % interval by bootstrap over places {low:.2f} to {high:.2f}).\n"
    )
    bins = {"simulated": matched_overlap(simulated), "real": matched_overlap(real)}
    rows = [
        (label, kind, *(f"{rate.k} of {rate.n}" if rate.n else "-" for rate in bins[kind][label]))
        for label in labels
        for kind in bins
    ]
    heads = [f"{low:g} to {min(1.0, high):g}" for low, high in pairwise(OVERLAPS)]
    return "\n".join([tau, PREDICTION_EXPLAINED, markdown(("method", "pairs", *heads), rows)])


def _size(track_results: TrackResults, ids: Mapping[str, str]) -> str:
    pairs, places = ({row[key] for row in track_results.rows} for key in ("pair_id", "place"))
    named = f" Data set `{ids[track_results.suite]}`." if track_results.suite in ids else ""
    return (
        f"{len(pairs)} pairs from {len(places)} places.{named}\n\n{versions_line(track_results.rows)}".rstrip("\n")
        + "\n"
    )


def _provenance(runs: Runs) -> str:
    commits = sorted({record.commit[:12] for record in runs.provenance})
    machines = sorted({record.machine for record in runs.provenance})
    made = f"Commit {', '.join(commits)}; {'; '.join(machines)}."
    return f"## How it was made\n\n    make results\n\nWhat is finished of it is on this page. {made}\n"


INTRODUCTION = """# Leaderboard

Every method gets the same pairs; k of n with share and 95 % interval by bootstrap over places, most right first.
*Right and accepted*: of required pairs (one place, overlap 0.15 or more). *Area*: the same without a single limit of
the error: the area, 0 to 1, under the share of these pairs that is accepted with an error of at most e, for e from 0
to 5 % of L, the extent of map A. *Best right*: the first candidate is right, whatever the verdict. *Wrong*: accepted
though wrong. *False merges*: pairs of two places that are accepted. *Checked*: right, and wrong or falsely merged,
where the judge of `rectmerge check` has the last word, as in `merge`. *AURC*: area under the risk-coverage curve,
lower is better. *e*: median error of the best candidate, a pair without one counting as worst. Labels that end in
`-tuned` are the same methods with the parameters that `rectbench tune` found: twelve configurations of each, its
authors' own the first, on every fourth pair of the split train of `standard`; taken is the one of least area under the
risk-coverage curve, and another threshold only where it is surely better. Both lines stand, whatever came out here.
The others have their authors' parameters as far as we know them, and defaults of our own elsewhere. The baselines are
written from their articles, some from the outline alone: the docstring of each names its source, our own choices, and
the extension for an unknown scale. The weights of `robust` are fitted to the split train of `standard` and `trust`,
and to the maps of the real sets: its lines on `real_maps`, `real_lasers` and `real_places` are of pairs that the fit
has seen; `rectbench calibrate` tells what it does in folds of places that a fit has not seen.
`rectbench report` shows the same runs with charts and every pair.
"""
SUBMISSIONS_EXPLAINED = """*Reported*: labels with a name in brackets are submissions; a dash stands for what they lack.
What is *self-reported* is the word of who handed it in; what is *verified* was run again, with the same result on all
rows or on as many as it says. Times are of their machines.
"""
FIRST_EXPLAINED = """The first of each box, with its pairs right and accepted; of equals who has fewest wrong ones
accepted.
"""
PREDICTION_EXPLAINED = """Right and accepted at equal true overlap, on simulated (`standard`) and real pairs
(`real_maps`, `real_lasers`, `real_places`). Real hand-held maps bend; simulated ones mostly do not.
"""
