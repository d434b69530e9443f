"""Charts of the report as SVG: text in the page's colour, lines of different colours and markers."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from scenarios.report.reading import TrackResults
from scenarios.report.standings import Standing, confident, rate_of, risks
from scenarios.scoring.row import Row

LONG = re.compile(r"(?<![\w.])(-?\d+\.\d\d)\d+")  # a number with more digits than a picture shows
INK = "#010203"  # replaced by the page's text colour
# Okabe and Ito, "Color Universal Design", without black and yellow; each line also has its own marker
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">")
MAX_LINES = 8
BINS = 10
SIZE, TALL = (5.2, 4.0), (5.2, 5.0)  # inches
Lines = Mapping[str, list[Row]]


@dataclass(frozen=True, slots=True)
class Variable:
    """Variable of success charts: name, edges of its bins, and its value in a row, None where unknown."""

    name: str
    edges: tuple[float, ...]
    value_in: Callable[[Row], float | None]


def _ratio(row: Row) -> float | None:
    info = row["info"] or {}
    size_b, size_a = info.get("resolution_b"), info.get("resolution_a")
    return float(size_b) / float(size_a) if size_a and size_b else None


def _drift(row: Row) -> float | None:
    residual, extent = row["residual_px"], row["extent_px"]
    return 100 * residual / extent if residual is not None and extent else None


VARIABLES = (
    Variable("true overlap", (0.05, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0001), lambda row: row["overlap"]),
    Variable("noise level", (-0.5, 0.5, 1.5, 2.5, 3.5), lambda row: (row["info"] or {}).get("noise")),
    Variable("cells of A per cell of B", (0.0, 0.7, 0.85, 1.15, 1.4, 10.0), _ratio),
    Variable("drift: residual of the truth, % of L", (0.0, 0.05, 0.2, 0.5, 1.5, 100.0), _drift),
)


def shown_lines(track_results: TrackResults, standings: Sequence[Standing]) -> Lines:
    """Choose the lines to draw: the best label of each family of labels, at most the best eight.

    The labels ``icp`` and ``icp-tuned`` are of one family.
    """
    rows = track_results.by_method()
    chosen: dict[str, str] = {}
    for line in standings:
        chosen.setdefault(line.label.removesuffix("-tuned"), line.label)
    return {label: rows[label] for label in list(chosen.values())[:MAX_LINES]}


def success_charts(lines: Lines) -> list[str]:
    """Draw the share of required pairs that are right and accepted against each variable of the rows."""
    return [chart for variable in VARIABLES if (chart := _success(lines, variable))]


def recall_chart(lines: Lines) -> str:
    """Draw the share of required pairs accepted with an error of at most e."""
    figure, axes = _axes("error e over the extent L of map A", "accepted so exactly, share of pairs")
    limits = np.logspace(-4, -1, 61)
    for style, (label, rows) in zip(_styles(), lines.items(), strict=False):
        required = [row for row in rows if row["stratum"] == "required"]
        errors = np.array(
            [row["errors"]["e_over_l"] for row in required if row["verdict"] == "accepted" and row["errors"]]
        )
        shares = [(errors <= limit).sum() / max(1, len(required)) for limit in limits]
        axes.plot(limits, shares, label=label, markevery=12, **style)
    axes.axvline(0.01, color=INK, lw=0.6, ls=":")
    axes.set_xscale("log")
    axes.set_ylim(-0.02, 1.02)
    return _svg(figure, axes)


def time_chart(standings: Sequence[Standing]) -> str:
    """Draw time against accuracy, a point for every label."""
    from matplotlib.ticker import NullFormatter

    figure, axes = _axes("median processor time of an answer, seconds", "right and accepted, share of pairs", TALL)
    for k, line in enumerate(line for line in standings if line.seconds and line.right.n):
        style = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
        value = line.right.value or 0.0
        bars = [[value - min(value, line.right.low)], [max(value, line.right.high) - value]]
        axes.errorbar(line.seconds, value, yerr=bars, lw=0.8, ls="", label=line.label, **style)
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(-0.02, 1.02)
    return _svg(figure, axes)


def risk_chart(lines: Lines) -> str:
    """Draw the share of wrong answers among the most confident against the share that is kept."""
    figure, axes = _axes(
        "coverage: share of all pairs that is kept, most confident first", "risk: share wrong of these"
    )
    for style, (label, rows) in zip(_styles(), lines.items(), strict=False):
        confidence, right = confident(rows)
        if len(right):
            kept = np.arange(1, len(right) + 1) / len(rows)
            axes.plot(kept, risks(confidence, right), label=label, markevery=max(1, len(right) // 6), **style)
    axes.set_ylim(-0.02, 1.02)
    return _svg(figure, axes)


def reliability_chart(lines: Lines) -> str:
    """Draw the share that is right against the confidence, in bins of equal count."""
    figure, axes = _axes("mean confidence", "share right")
    axes.plot([0, 1], [0, 1], color=INK, lw=0.6, ls=":")
    for style, (label, rows) in zip(_styles(), lines.items(), strict=False):
        confidence, right = confident(rows)
        parts = [part for part in np.array_split(np.arange(len(right)), BINS) if len(part)]
        points = [(confidence[part].mean(), right[part].mean()) for part in parts]
        if points:
            axes.plot(*zip(*points, strict=True), label=label, **style)
    axes.set_ylim(-0.02, 1.02)
    return _svg(figure, axes)


def _success(lines: Lines, variable: Variable) -> str | None:
    known = {
        label: [row for row in rows if row["stratum"] != "unrelated" and variable.value_in(row) is not None]
        for label, rows in lines.items()
    }
    filled = {_bin(variable, row) for rows in known.values() for row in rows} - {None}
    if len(filled) < 2:
        return None
    figure, axes = _axes(variable.name, "right and accepted, share")
    for k, (style, (label, rows)) in enumerate(zip(_styles(), known.items(), strict=False)):
        at, rates = [], []
        for place in range(len(variable.edges) - 1):
            if held := [row for row in rows if _bin(variable, row) == place]:
                at.append(place)
                rates.append(rate_of(held, "right-accepted"))
        values = np.array([rate.value for rate in rates], np.float64)
        bars = [
            np.maximum(values - [rate.low for rate in rates], 0),
            np.maximum([rate.high for rate in rates] - values, 0),
        ]
        axes.errorbar(
            np.array(at) + 0.05 * (k - len(known) / 2), values, yerr=bars, elinewidth=0.6, label=label, **style
        )
    names = [_named(*ends) for ends in pairwise(variable.edges)]
    places = sorted(place for place in filled if place is not None)
    axes.set_xticks(places, [names[place] for place in places])
    axes.set_ylim(-0.02, 1.02)
    return _svg(figure, axes)


def _bin(variable: Variable, row: Row) -> int | None:
    value = variable.value_in(row)
    place = math.nan if value is None else int(np.searchsorted(variable.edges, value, side="right")) - 1
    return int(place) if 0 <= place < len(variable.edges) - 1 else None


def _named(low: float, high: float) -> str:
    if high - low == 1 and low % 1:
        return f"{(low + high) / 2:g}"  # a whole number's bin
    return f"≥{low:g}" if high >= 10 else f"{low:g}–{round(high, 3):g}"


def _styles() -> list[dict[str, Any]]:
    return [
        {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k], "ms": 4.5, "lw": 1.3, "ls": "-" if k < 6 else "--"}
        for k in range(MAX_LINES)
    ]


def _axes(across: str, up: str, size: tuple[float, float] = SIZE) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(across, color=INK, fontsize=9)
    axes.set_ylabel(up, color=INK, fontsize=9)
    axes.tick_params(colors=INK, labelsize=8, which="both")
    axes.patch.set_alpha(0)
    axes.grid(visible=True, color=INK, alpha=0.12, lw=0.6)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(INK)
    return figure, axes


def _svg(figure: Any, axes: Any) -> str:
    """Return a figure as SVG for a page: no header, unique ids, text in the page's colour."""
    import matplotlib as mpl

    columns = 3 if len(axes.get_legend_handles_labels()[1]) <= MAX_LINES else 2
    figure.legend(fontsize=7, labelcolor=INK, frameon=False, loc="outside lower center", ncols=columns)
    figure.patch.set_alpha(0)
    written = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": axes.get_xlabel(), "font.family": "sans-serif"}):
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
    text = written.getvalue()
    return LONG.sub(r"\1", text[text.index("<svg") :]).replace(INK, "currentColor")
