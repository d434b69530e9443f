"""Difficulty grid: heat maps of every method over overlap, noise and what differs, and the first of each box."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scenarios.report.reading import TrackResults
from scenarios.scoring.row import Row

DIFFERS = {"rigid": "rigid", "slam": "slam", "slam-bent": "slam and bent"}  # beginnings of the variants' names
_VARIANT = re.compile(rf"({'|'.join(sorted(DIFFERS, key=len, reverse=True))})-([01]\.\d+)")  # and the overlap
NOBODY = "nobody"
PALE, FULL = (0xF7, 0xF7, 0xF7), (0x00, 0x72, 0xB2)  # of the worst and of the best cells
DARK_FROM = 0.6  # shade from which text is white
# best and worst values of the shades; the limit of a right answer is 1 % of L
ERROR_PERCENT, SECONDS = (0.1, 10.0), (0.01, 10.0)


@dataclass(frozen=True, slots=True, order=True)
class Box:
    """Box of the grid: what differs, as an index into `DIFFERS`, the noise level, and the overlap."""

    differs: int
    noise: str
    overlap: float

    @property
    def line(self) -> str:
        """Name of its line in tables."""
        return f"{list(DIFFERS.values())[self.differs]}, noise {self.noise}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Cell of a heat map: its text, and its colours as CSS."""

    text: str
    style: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeatMap:
    """Heat map of one value: title, the overlaps of its columns, and its lines of cells by name."""

    title: str
    columns: Sequence[str]
    lines: Sequence[tuple[str, Sequence[Cell]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Leader:
    """First methods of a box: most pairs right and accepted, then fewest wrong and accepted; none where none is right.

    Parameters
    ----------
    labels
        Methods that share the first place.
    right, wrong, n
        Their counts, and the number of the box's pairs.
    """

    labels: tuple[str, ...]
    right: int
    wrong: int
    n: int

    def __str__(self) -> str:
        return f"{' + '.join(self.labels)} {self.right} of {self.n}" if self.labels else f"{NOBODY}, 0 of {self.n}"


def box_of(info: Mapping[str, Any] | None) -> Box | None:
    """Return the box of a pair by what its row knows of it; None of a pair of no grid, or where that is not known.

    A box is known by the variant's name, such as ``slam-bent-0.28``, and the noise level.
    """
    known = info or {}
    named, noise = _VARIANT.fullmatch(str(known.get("variant"))), known.get("noise")
    return None if named is None or noise is None else Box(list(DIFFERS).index(named[1]), str(noise), float(named[2]))


def boxes_of_pairs(rows: Sequence[Row]) -> dict[str, Box]:
    """Return the box of each pair, from any of its rows: that of a failure may not know it."""
    return {row["pair_id"]: box for row in rows if (box := box_of(row.get("info")))}


def boxes_of(rows: Sequence[Row], of_pairs: Mapping[str, Box]) -> dict[Box, list[Row]]:
    """Return the rows of each box, in order; rows of pairs that are of none are left out."""
    boxes: dict[Box, list[Row]] = {}
    for row in rows:
        if row["pair_id"] in of_pairs:
            boxes.setdefault(of_pairs[row["pair_id"]], []).append(row)
    return dict(sorted(boxes.items()))


def heat_maps(track_results: TrackResults) -> list[tuple[str, list[HeatMap]]]:
    """Return each method's heat maps of success, error and time; none where the rows are no grid."""
    of_pairs = boxes_of_pairs(track_results.rows)
    by_method = {label: boxes_of(rows, of_pairs) for label, rows in track_results.by_method().items()}
    return [(label, _maps(boxes)) for label, boxes in by_method.items() if boxes]


def leaders(track_results: TrackResults) -> dict[Box, Leader]:
    """Return the first methods of each box; none where the rows are no grid."""
    boxes = boxes_of(track_results.rows, boxes_of_pairs(track_results.rows))
    return {box: _leader(rows) for box, rows in boxes.items()}


def leaders_map(first: Mapping[Box, Leader]) -> HeatMap:
    """Lay the first methods of each box out as a table."""
    return _table("first of each box", {box: Cell(text=str(leader)) for box, leader in first.items()})


def leaders_line(first: Mapping[Box, Leader]) -> str:
    """Say how often each method is first, alone or with others."""
    named = Counter(label for leader in first.values() for label in leader.labels)
    alone = Counter(leader.labels[0] for leader in first.values() if len(leader.labels) == 1)
    parts = [
        f"{label} is first in {count} of {len(first)} boxes, in {alone[label]} alone"
        for label, count in named.most_common()
    ]
    nobody = sum(not leader.labels for leader in first.values())
    return "; ".join([*parts, *([f"{NOBODY} is right in {nobody}"] if nobody else [])]) + "."


def _leader(rows: Sequence[Row]) -> Leader:
    """Compare the methods on one box."""
    counts: dict[str, list[int]] = {}
    for row in rows:
        count = counts.setdefault(row["method"], [0, 0, 0])
        count[0] += row["outcome"] == "right-accepted"
        count[1] += row["outcome"] == "wrong-accepted"
        count[2] += 1
    right, wrong, n = max(counts.values(), key=lambda count: (count[0], -count[1]))
    labels = tuple(label for label, count in counts.items() if right and count[:2] == [right, wrong])
    return Leader(labels=labels, right=right, wrong=wrong, n=n)


def _maps(boxes: Mapping[Box, Sequence[Row]]) -> list[HeatMap]:
    """Return the three heat maps of one method."""
    return [
        _table("right and accepted", {box: _success(rows) for box, rows in boxes.items()}),
        _table("median error, % of L", {box: _error(rows) for box, rows in boxes.items()}),
        _table("median time, CPU s", {box: _time(rows) for box, rows in boxes.items()}),
    ]


def _table(title: str, cells: Mapping[Box, Cell]) -> HeatMap:
    """Lay cells out: a line for what differs and noise, a column for an overlap."""
    overlaps = sorted({box.overlap for box in cells})
    corners = dict.fromkeys(replace(box, overlap=0.0) for box in cells)
    blank = Cell(text="-")
    lines = [
        (corner.line, [cells.get(replace(corner, overlap=overlap), blank) for overlap in overlaps])
        for corner in corners
    ]
    return HeatMap(title=title, columns=[f"{overlap:g}" for overlap in overlaps], lines=lines)


def _success(rows: Sequence[Row]) -> Cell:
    right, wrong = (sum(row["outcome"] == f"{name}-accepted" for row in rows) for name in ("right", "wrong"))
    text = f"{right} of {len(rows)}" + (f", {wrong} wrong" if wrong else "")
    return Cell(text=text, style=_style(right / len(rows)))


def _error(rows: Sequence[Row]) -> Cell:
    """Return the median error of the best candidates; a pair without one counts as worst."""
    median = float(np.median([100 * row["errors"]["e_over_l"] if row["errors"] else math.inf for row in rows]))
    return Cell(text=f"{median:.2f}" if math.isfinite(median) else "none", style=_style(_shade(median, *ERROR_PERCENT)))


def _time(rows: Sequence[Row]) -> Cell:
    seconds = list(_seconds(rows))
    if not seconds:
        return Cell(text="-")
    median = float(np.median(seconds))
    return Cell(text=f"{median:.2f}", style=_style(_shade(median, *SECONDS)))


def _seconds(rows: Sequence[Row]) -> Iterator[float]:
    for row in rows:
        if row["seconds"] and row["seconds"]["cpu"] is not None:
            yield row["seconds"]["cpu"]


def _shade(value: float, best: float, worst: float) -> float:
    """Return 1 at the best value and better, 0 at the worst and worse, on a scale of logarithms between."""
    if not best < value < worst:
        return float(value <= best)
    return math.log(worst / value) / math.log(worst / best)


def _style(shade: float) -> str:
    """Return the colours of a shade, 0 to 1, as CSS."""
    mixed = (round(pale + shade * (full - pale)) for pale, full in zip(PALE, FULL, strict=True))
    ink = "#fff" if shade >= DARK_FROM else "#1c1c1c"
    return f"background:#{''.join(f'{value:02x}' for value in mixed)};color:{ink}"
