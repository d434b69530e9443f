"""Page that compares simulated pairs with real ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.scoring.markdown import markdown
from scenarios.studies.examination import Finding

PERCENTILES = (5, 25, 50, 75, 95)
MEASURES = {  # by name: heading and format
    "overlap": ("overlap", "{:.2f}"),
    "residual": ("residual, % of L", "{:.2%}"),
    "affine": ("of it removed by an affine map", "{:.0%}"),
    "wall_cells": ("wall thickness, cells", "{:.1f}"),
    "speckle": ("speckle, % of known cells", "{:.2%}"),
}
DECIMALS = 4  # of compared values
OVERLAP_TOLERANCE = 0.05


def page(simulated: Sequence[Finding], real: Mapping[str, Sequence[Finding]], machine: Mapping[str, Any]) -> str:
    """Return the page in Markdown."""
    return "\n".join(
        [
            INTRODUCTION,
            distributions({"simulated": simulated, **real}),
            EXPLAINED,
            coverage({"simulated": simulated, **real}),
            "## How sturdy it is\n",
            robustness(simulated),
            families_table(simulated),
            _failures(simulated),
            "## How it was made\n",
            PROVENANCE.format(commit=machine["commit"], cpu=machine["processor"]),
        ]
    )


def distributions(sets: Mapping[str, Sequence[Finding]]) -> str:
    """Tabulate the percentiles of every measure in every set."""
    rows = []
    for name, (title, form) in MEASURES.items():
        for label, findings in sets.items():
            values = _values(findings, name)
            cells = [form.format(value) for value in np.percentile(values, PERCENTILES)] if len(values) else ["-"] * 5
            rows.append([title, label, str(len(values)), *cells])
    return markdown(["", "pairs", "n", *(f"{p} %" for p in PERCENTILES)], rows)


def coverage(sets: Mapping[str, Sequence[Finding]]) -> str:
    """Count for every measure the real values within the central 95 % of the simulated ones."""
    rows = []
    for name, (title, _) in MEASURES.items():
        simulated = _values(sets["simulated"], name)
        low, high = np.percentile(simulated, [2.5, 97.5]) if len(simulated) else (np.nan, np.nan)
        for label in list(sets)[1:]:
            values = _values(sets[label], name)
            within = int(((values >= low) & (values <= high)).sum())
            rows.append([title, label, f"{within} of {len(values)}" if len(values) else "-"])
    return markdown(["", "real pairs", "within the simulated 95 %"], rows)


def robustness(findings: Sequence[Finding]) -> str:
    """Count crashes, faults, refusals and discarded missions."""
    pairs = [finding for finding in findings if finding.measures]
    offsets = [abs(f.measures["overlap"] - f.wanted_overlap) for f in pairs if f.wanted_overlap is not None]
    memory = max((finding.peak_mb or 0.0 for finding in findings), default=0.0)
    lines = [
        ["missions run", str(len(findings))],
        ["crashes", str(sum(finding.is_crash for finding in findings))],
        ["robots through a wall, or stuck without saying so", str(sum(len(finding.faults) for finding in findings))],
        ["no maps with the wanted overlap in any try, said so", str(len(findings) - len(pairs) - _crashes(findings))],
        ["tries discarded before one succeeded", str(sum(finding.discarded for finding in findings))],
        [
            f"overlap of the finished maps within {OVERLAP_TOLERANCE} of the wanted",
            f"{sum(d <= OVERLAP_TOLERANCE for d in offsets)} of {len(offsets)}",
        ],
        ["furthest off", f"{max(offsets, default=0.0):.3f}"],
        ["highest memory of a worker", f"{memory:.0f} MB"],
    ]
    return markdown(["", ""], lines)


def families_table(findings: Sequence[Finding]) -> str:
    """Count pairs by family, with the median residual."""
    rows = []
    for family in dict.fromkeys(finding.origin for finding in findings):
        own = [finding for finding in findings if finding.origin == family]
        residuals, overlaps = _values(own, "residual"), _values(own, "overlap")
        bent = int((residuals > 0.015).sum())
        medians = [f"{np.median(overlaps):.2f}", f"{np.median(residuals):.2%}"] if len(residuals) else ["-", "-"]
        rows.append(
            [family, str(len(own)), str(len(overlaps)), *medians, str(bent), str(sum(f.discarded for f in own))]
        )
    return markdown(["family", "missions", "pairs", "overlap", "residual, of L", "bent", "discarded"], rows)


def _failures(findings: Sequence[Finding]) -> str:
    reasons = Counter(f"{finding.origin}: {finding.failure}" for finding in findings if finding.failure)
    faults = Counter(f"{finding.origin}: {fault}" for finding in findings for fault in finding.faults)
    return "".join(f"- {reason}\n" for reason in [*reasons, *faults])


def _crashes(findings: Sequence[Finding]) -> int:
    return sum(finding.is_crash for finding in findings)


def _values(findings: Sequence[Finding], name: str) -> NDArray[np.float64]:
    return np.round([finding.measures[name] for finding in findings if name in finding.measures], DECIMALS)


INTRODUCTION = """# Simulated pairs and real ones

Missions of two robots, drawn at random: every family of buildings in turn, any of the scanners, tours and frontiers,
any wanted overlap from 0.2 to 1, cells of 2 to 13 cm, noise levels 0 to 2, maps by `slam` poses of better and worse
mappers; a third of the pairs are also stretched by up to 3 %, bent by up to 1.5 degrees and drawn with fat walls, as
hand-held sensors draw them. They are compared with the pairs that people made by hand (`real_maps`, hand-held, truth by
hand-made points) and cut out of laser logs (`real_lasers`, exact truth, so without a residual).

![24 pairs of other missions: A, B, and B on A by the truth](sheet.png)
"""
EXPLAINED = """
A pair's residual is the RMSE of its best similarity on its control points; L is the extent of A's known cells. What an
affine map removes of it is due to stretch and shear; the rest is bending. Thickness and speckle are what
`rectmerge inspect` tells of a map. [Simulated maps beside those of robots](maps.md), by more descriptors.
"""
PROVENANCE = """`rectbench realism MAPS -o results/worlds` at commit {commit}, on {cpu}; MAPS is a
folder with the real maps, which are not part of this repository. Same command and code, same figures, memory aside.
"""
