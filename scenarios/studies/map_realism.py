"""Comparison of simulated maps with those of robots: descriptors, the classifier, contact sheets, and the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.drawing.maps import draw_map, side_by_side
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.io.atomic_file import replace_file
from scenarios.corruption import NoiseLevel
from scenarios.dataset.contact_sheet import paletted_png
from scenarios.scoring.markdown import markdown
from scenarios.studies.map_population import DescribedMap, MappedMission, real_population, values_of
from scenarios.studies.noise_fit import TAILS, WORSE, aim_of, rank_among
from scenarios.studies.real_or_simulated import Telling, halves_auc, tell_apart

PAGE, SHEET = "maps.md", "maps.png"
LEVELS: tuple[NoiseLevel, ...] = (1, 2)  # those that are held against the bars, together the mixture
OLD: NoiseLevel = "cells-1"
SHOWN, COLUMNS, TILE_PX = 12, 6, 200  # maps of each sort, in a row, and cells along a side of each that are shown
TAIL_FACTOR, HIGHEST_AUC = 2.0, 0.75  # bars


@dataclass(frozen=True, slots=True, eq=False)
class MapRealism:
    """Populations of maps, and how well a classifier tells them apart.

    Parameters
    ----------
    real
        Maps of robots.
    simulated
        Maps of the same missions, by noise level.
    mixture, old
        The classifier on levels 1 and 2 together, every mission under one of both, and on the even noise of the cells.
    halves
        Area under its curve of one half of the real places against the other.
    """

    real: Sequence[DescribedMap]
    simulated: Mapping[NoiseLevel, Sequence[DescribedMap]]
    mixture: Telling
    old: Telling
    halves: float


def compare_maps(maps: Path, missions: Sequence[MappedMission]) -> MapRealism:
    """Describe the maps of robots and those of missions at every level, and train the classifiers."""
    real = real_population(maps)
    simulated = {level: [mission.described(level) for mission in missions] for level in (*LEVELS, OLD)}
    return MapRealism(
        real=real,
        simulated=simulated,
        mixture=tell_apart(real, mixed(simulated)),
        old=tell_apart(real, simulated[OLD]),
        halves=halves_auc(real),
    )


def mixed(simulated: Mapping[NoiseLevel, Sequence[DescribedMap]]) -> list[DescribedMap]:
    """Return the maps of missions under levels 1 and 2 in turn, half and half."""
    first, second = (simulated[level] for level in LEVELS)
    return [(first, second)[k % 2][k] for k in range(len(first))]


def write_map_realism(found: MapRealism, folder: Path, machine: Mapping[str, Any]) -> None:
    """Write the page and the sheet of maps into a folder."""
    replace_file(folder / SHEET, paletted_png(sheet(found.mixture)))
    replace_file(folder / PAGE, page(found, machine).encode())


def page(found: MapRealism, machine: Mapping[str, Any]) -> str:
    """Return the page in Markdown."""
    places = len({one.group for one in found.real})
    return "\n".join(
        [
            INTRODUCTION.format(real=len(found.real), places=places, missions=len(found.simulated[OLD])),
            descriptor_table(found),
            TABLE_EXPLAINED,
            "## Can they be told apart?\n",
            classifier_table(found),
            CLASSIFIER_EXPLAINED,
            _importances(found.mixture),
            SHEET_EXPLAINED,
            PROVENANCE.format(commit=machine["commit"], cpu=machine["processor"]),
        ]
    )


def descriptor_table(found: MapRealism) -> str:
    """Tabulate the percentiles of every descriptor, and whether the medians and tails reach their bars."""
    rows = []
    for name in WORSE:
        real = values_of(found.real, name)
        cells = [name, percentiles_text(real, (10, 25, 50, 75, 90))]
        for level in LEVELS:
            values = values_of(found.simulated[level], name)
            rank = rank_among(real, float(np.median(values)))
            least, _, most = aim_of(name, int(level))
            is_met = "" if least <= rank <= most else " **off**"
            cells.append(f"{percentiles_text(values, (10, 50, 90))}; at {100 * rank:.0f} %{is_met}")
        both = np.concatenate([values_of(found.simulated[level], name) for level in LEVELS])
        cells.append(", ".join(f"{ratio:.2f}{'' if _is_near(ratio) else ' **off**'}" for ratio in _tails(real, both)))
        cells.append(percentiles_text(values_of(found.simulated[OLD], name), (10, 50, 90)))
        rows.append(cells)
    heads = ("descriptor", "robots", "noise 1", "noise 2", "10 and 90 % of both, over real", f"noise {OLD}")
    return markdown(heads, rows)


def classifier_table(found: MapRealism) -> str:
    """Tabulate the classifier's areas under the curve."""
    lines = [
        ("noise 1 and 2, half and half", found.mixture.auc, found.mixture.maps),
        (f"noise {OLD}", found.old.auc, found.old.maps),
    ]
    rows = [(name, f"{auc:.2f}", f"{maps} and {maps}") for name, auc, maps in lines]
    rows.append(("one half of the real places against the other", f"{found.halves:.2f}", "mean of 5 splits"))
    return markdown(("against maps of robots", "area under the curve", "maps"), rows)


def sheet(telling: Telling) -> NDArray[np.uint8]:
    """Draw the simulated maps that pass best for real ones, and those that pass worst; shape (H, W, 3), RGB."""
    order = np.argsort(-telling.realness, kind="stable")
    shown = [*order[:SHOWN], *order[-SHOWN:]]
    captions = [f"{telling.simulated[k].group} {telling.realness[k]:.2f}" for k in shown]
    return side_by_side([_window(telling.simulated[k]) for k in shown], captions, columns=COLUMNS)


def _window(one: DescribedMap) -> NDArray[np.uint8]:
    """Draw a square window about the middle of a map's floor."""
    cells = np.pad(one.grid.occupancy, TILE_PX, constant_values=UNKNOWN)
    row, col = (int(np.median(line)) + TILE_PX for line in np.nonzero(one.grid.free))
    half = TILE_PX // 2
    return draw_map(OccupancyGrid(cells[row - half : row + half, col - half : col + half]))


def percentiles_text(values: NDArray[np.float64], percents: Sequence[float]) -> str:
    """Return percentiles to about three digits, parted by strokes.

    Examples
    --------
    >>> percentiles_text(np.arange(101.0), (10, 50, 90))
    '10 / 50 / 90'
    """
    return " / ".join(f"{value:.3g}" for value in np.percentile(values, percents))


def _tails(real: NDArray[np.float64], both: NDArray[np.float64]) -> list[float]:
    """Return the 10 and 90 % of simulated values over those of real ones; NaN where the real one is 0."""
    pairs = zip(np.percentile(both, TAILS), np.percentile(real, TAILS), strict=True)
    return [float(ours / theirs) if theirs else float("nan") for ours, theirs in pairs]


def _is_near(ratio: float) -> bool:
    return 1 / TAIL_FACTOR <= ratio <= TAIL_FACTOR


def _importances(telling: Telling) -> str:
    ordered = sorted(telling.importances.items(), key=lambda item: -item[1])
    return "It looks at: " + ", ".join(f"{name} {share:.2f}" for name, share in ordered) + ".\n"


INTRODUCTION = """# Simulated maps and those of robots

{real} maps of {places} places that robots made (`real_places`, the first map of every pair, windows left out, and
`real_lasers`), beside maps A of {missions} missions of the suite `standard`, split test, at noise 1, at noise 2 and
with the even noise of the cells that version 1 of the suites had. The levels were fitted on missions of the split
train. The descriptors are those of `rectmerge inspect --json` (`rectmerge.analysis.descriptors`), free of a map's size.
"""
TABLE_EXPLAINED = """Percentiles 10 / 25 / 50 / 75 / 90 of the robots' maps, 10 / 50 / 90 of simulated ones, and the
percentage of the robots' maps that have less than the simulated median. Bars: this median lies at 25 to 50 % for noise
1 and at 50 to 75 % for noise 2, in the direction of worse (straightness: less is worse; clumping and nearness to walls
have none: 25 to 75 %); 10 and 90 % of both levels together are within a factor of 2 of the robots'. **Off**: not so.
"""
CLASSIFIER_EXPLAINED = """A random forest of 300 trees that must tell simulated maps from real ones by their
descriptors, in five folds that part no place and no family of buildings, real and simulated maps matched one to one in
free area. 0.5 is a guess, 1 tells every map; the bar is 0.75.
"""
SHEET_EXPLAINED = """![simulated maps: 12 that pass best for real ones, and 12 that pass worst](maps.png)

Simulated maps, 200 cells of each, with the family of the building and the probability of being real that the
classifier gives: the upper two rows are the most probable ones, the lower two the least.
"""
PROVENANCE = """## How it was made

`rectbench realism MAPS -o results/worlds` at commit {commit}, on {cpu}; MAPS is a
folder with the real maps, which are not part of this repository. `rectbench fit-noise MAPS` fits the levels.
"""
