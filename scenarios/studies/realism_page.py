"""Page that compares simulated pairs with real ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from scenarios.studies.headline import markdown

if TYPE_CHECKING:
    from scenarios.studies.realism import Finding

PERCENTILES = (5, 25, 50, 75, 95)
FIGURES = {  # name: what it is, and how it is written
    "overlap": ("overlap", "{:.2f}"),
    "residual": ("residual, % of L", "{:.2%}"),
    "affine": ("of it removed by an affine map", "{:.0%}"),
    "wall_cells": ("wall thickness, cells", "{:.1f}"),
    "speckle": ("speckle, % of known cells", "{:.2%}"),
}
PLACES = 4  # what is compared is rounded to so many
WITHIN = 0.05  # a mission keeps its wanted overlap this closely


def page(simulated: Sequence[Finding], real: Mapping[str, Sequence[Finding]], machine: Mapping[str, Any]) -> str:
    """Lay the comparison out as Markdown."""
    return "\n".join(
        [
            INTRODUCTION,
            distributions({"simulated": simulated, **real}),
            EXPLAINED,
            coverage({"simulated": simulated, **real}),
            "## How sturdy it is\n",
            sturdiness(simulated),
            families_table(simulated),
            _failures(simulated),
            "## How it was made\n",
            PROVENANCE.format(commit=machine["commit"], cpu=machine["processor"]),
        ]
    )


def distributions(sets: Mapping[str, Sequence[Finding]]) -> str:
    """Tabulate the percentiles of every figure in every set."""
    rows = []
    for name, (title, form) in FIGURES.items():
        for label, findings in sets.items():
            values = _values(findings, name)
            cells = [form.format(value) for value in np.percentile(values, PERCENTILES)] if len(values) else ["-"] * 5
            rows.append([title, label, str(len(values)), *cells])
    return markdown(["", "pairs", "n", *(f"{p} %" for p in PERCENTILES)], rows)


def coverage(sets: Mapping[str, Sequence[Finding]]) -> str:
    """Tell for every figure which share of the real values lies where 95 % of the simulated ones do."""
    rows = []
    for name, (title, _) in FIGURES.items():
        made = _values(sets["simulated"], name)
        low, high = np.percentile(made, [2.5, 97.5]) if len(made) else (np.nan, np.nan)
        for label in list(sets)[1:]:
            values = _values(sets[label], name)
            within = int(((values >= low) & (values <= high)).sum())
            rows.append([title, label, f"{within} of {len(values)}" if len(values) else "-"])
    return markdown(["", "real pairs", "within the simulated 95 %"], rows)


def sturdiness(findings: Sequence[Finding]) -> str:
    """Count what went wrong, and what was discarded."""
    made = [finding for finding in findings if finding.figures]
    off = [abs(f.figures["overlap"] - f.wanted) for f in made if f.wanted is not None]
    memory = max((finding.peak_mb or 0.0 for finding in findings), default=0.0)
    lines = [
        ["missions run", str(len(findings))],
        ["crashes", str(sum(finding.is_crash for finding in findings))],
        ["robots through a wall, or stuck without saying so", str(sum(len(finding.faults) for finding in findings))],
        ["no maps with the wanted overlap in any try, said so", str(len(findings) - len(made) - _crashes(findings))],
        ["tries discarded before one succeeded", str(sum(finding.discarded for finding in findings))],
        [
            f"overlap of the finished maps within {WITHIN} of the wanted",
            f"{sum(d <= WITHIN for d in off)} of {len(off)}",
        ],
        ["furthest off", f"{max(off, default=0.0):.3f}"],
        ["highest memory of a worker", f"{memory:.0f} MB"],
    ]
    return markdown(["", ""], lines)


def families_table(findings: Sequence[Finding]) -> str:
    """Count pairs by family, with the median residual."""
    rows = []
    for family in dict.fromkeys(finding.kind for finding in findings):
        own = [finding for finding in findings if finding.kind == family]
        residuals, overlaps = _values(own, "residual"), _values(own, "overlap")
        bent = int((residuals > 0.015).sum())
        medians = [f"{np.median(overlaps):.2f}", f"{np.median(residuals):.2%}"] if len(residuals) else ["-", "-"]
        rows.append(
            [family, str(len(own)), str(len(overlaps)), *medians, str(bent), str(sum(f.discarded for f in own))]
        )
    return markdown(["family", "missions", "pairs", "overlap", "residual, of L", "bent", "discarded"], rows)


def _failures(findings: Sequence[Finding]) -> str:
    reasons = Counter(f"{finding.kind}: {finding.failure}" for finding in findings if finding.failure)
    faults = Counter(f"{finding.kind}: {fault}" for finding in findings for fault in finding.faults)
    return "".join(f"- {reason}\n" for reason in [*reasons, *faults])


def _crashes(findings: Sequence[Finding]) -> int:
    return sum(finding.is_crash for finding in findings)


def _values(findings: Sequence[Finding], name: str) -> NDArray[np.float64]:
    return np.round([finding.figures[name] for finding in findings if name in finding.figures], PLACES)


INTRODUCTION = """# Simulated pairs beside real ones

Missions of two robots, drawn at random: every family of buildings in turn, any of the scanners, tours and frontiers,
any wanted overlap from 0.2 to 1, cells of 2 to 13 cm, noise levels 0 to 2, maps by `slam` poses of better and worse
mappers; a third of the pairs are also stretched by up to 3 %, bent by up to 1.5 degrees and drawn with fat walls, as
hand-held sensors draw them. Beside them the pairs that people made by hand (`real_maps`, hand-held, truth by hand-made
points) and cut out of laser logs (`real_lasers`, exact truth, so without a residual).

![24 pairs of other missions: A, B, and B on A by the truth](sheet.png)
"""
EXPLAINED = """
A pair's residual is the RMSE of its best similarity on its control points; L is the extent of A's known cells. What an
affine map removes of it is due to stretch and shear; the rest is bending. Thickness and speckle are what
`rectmerge inspect` tells of a map.
"""
PROVENANCE = """`rectbench realism MAPS -o results/worlds` at commit {commit}, on {cpu}; MAPS is a
folder with the real maps, which are not part of this repository. Same command and code, same figures, memory aside.
"""
