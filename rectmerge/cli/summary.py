"""An answer in lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rectmerge.cli.placement_source import moved_cells, reach_cells

if TYPE_CHECKING:
    from rectmerge.alignment import Alignment, Candidate
    from rectmerge.grid import OccupancyGrid
    from rectmerge.robust.certificate import Certificate
    from rectmerge.similarity import Similarity

DOUBTFUL = 0.9  # below this confidence a yes asks to be looked at
CONTRADICTED = 0.1  # so does a conflict above this share: bent maps lie rightly on each other, and still not everywhere
MOST_LISTED = 5  # candidates
HEADS = ("candidate", "confidence", "rotation", "scale", "overlap", "conflict", "picture")


def describe(
    found: Alignment,
    files: Sequence[Path] = (),
    certificate: Certificate | None = None,
    *,
    is_given: bool = False,
    is_shaded: bool = False,
) -> str:
    """Tell the verdict, the best candidate, and the files that were written.

    Parameters
    ----------
    found, files, certificate
        The answer, what was written, and what --certify showed.
    is_given
        Whether somebody placed B.
    is_shaded
        Whether the merged map holds more than free, occupied and unknown.
    """
    lines = [f"{found.verdict}: {found.reason}", f"  method      {found.method}, {found.seconds:.2f} s"]
    if found or is_given:
        lines += [] if found else ["  the placement as it was judged:"]
        lines += _describe_candidate(found, found.candidates[0]) if found.candidates else []
    elif found.candidates:
        lines += _list_candidates(found, files)
    lines += _doubts(found) if found and files else []
    if certificate is not None:
        lines.append(f"  certified   {certificate}")
    if is_shaded:
        lines.append("  shades      in mode raw; costmaps take what is below lethal_cost_threshold, 100, for free")
    if files:
        lines.append(f"  written     {files[0].parent}: {', '.join(file.name for file in files)}")
    return "\n".join(lines)


def describe_check(found: Alignment, b: OccupancyGrid, told: Similarity) -> list[str]:
    """Tell how far a placement of B by hand was moved to be exact, its numbers to be pasted, and what fits better."""
    if not found.candidates:
        return []
    best, *others = found.candidates
    moved = moved_cells(b, told, best.pixels)
    is_near = moved <= reach_cells(b, best.pixels)
    if is_near:
        lines = [f"  made exact  by {moved:.1f} cells of A"]
    elif found:
        lines = [f"  moved       by {moved:.1f} cells of A, to where the walls agree"]
    else:
        lines = [f"  not exact   nothing fits near there: what was judged lies {moved:,.0f} cells of A away"]
    if found or is_near:
        lines.append(f"  to merge    {_as_option(best.pixels)}")
    better = [one for one in others if round(one.confidence, 2) > round(best.confidence, 2)]
    if better:
        away, number = min((moved_cells(b, told, one.pixels), found.candidates.index(one)) for one in better)
        nearest = found.candidates[number]
        told_of = f"candidate {number + 1}, {away:,.0f} cells of A away, confidence {nearest.confidence:.2f}"
        lines.append(f"  better      {told_of}: {_as_option(nearest.pixels)}")
    return lines


def _as_option(pixels: Similarity) -> str:
    (a, _, tx), (b, _, ty) = pixels.matrix.tolist()
    return f"--pixels={a:.9g},{b:.9g},{tx:.9g},{ty:.9g}"


def _doubts(found: Alignment) -> list[str]:
    """Ask for a look at the pictures of a yes, where it or the merged map is not beyond doubt."""
    lines = []
    if found.confidence < DOUBTFUL:
        lines.append("  look at     overlay.png before using the map: the method is not sure")
    if found.candidates[0].conflict > CONTRADICTED:
        lines.append("  look at     overlay.png and conflict.png before driving by the map: where the maps contradict")
        lines.append("              each other, walls stand double or break off")
    return lines


def _list_candidates(found: Alignment, files: Sequence[Path]) -> list[str]:
    """List the candidates of an answer that is no yes, a line each, and say how to take one."""
    pictures = {file.name for file in files}
    rows = [HEADS]
    for number, one in enumerate(found.candidates[:MOST_LISTED], start=1):
        shares = f"{one.overlap:.0%}", f"{one.conflict:.1%}"
        picture = f"overlay_{number}.png"
        shown = picture if picture in pictures else "-"
        rows.append((str(number), f"{one.confidence:.2f}", _turn(one), f"{one.pixels.scale:.4f}", *shares, shown))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  " + "  ".join(map(str.rjust, row, widths)) for row in rows]
    if found.scale.expected is not None:
        lines.append(f"  scale       {found.scale.expected:.4f} cells of A per cell of B by the resolutions")
    return [*lines, "  to take one look at its picture, and add --candidate K --force to the command"]


def _turn(candidate: Candidate) -> str:
    return f"{math.degrees(math.remainder(candidate.b_to_a.angle, math.tau)):+.2f} deg"


def _describe_candidate(found: Alignment, best: Candidate) -> list[str]:
    expected = found.scale.expected
    ratio = "" if expected is None else f", {expected:.4f} by the resolutions"
    return [
        f"  confidence  {best.confidence:.2f}",
        f"  scale       {best.pixels.scale:.4f} cells of A per cell of B{ratio}",
        f"  rotation    {_turn(best)}, counter-clockwise from B to A",
        f"  shift       {best.b_to_a.tx:+.2f}, {best.b_to_a.ty:+.2f} {found.unit}",
        f"  overlap     {best.overlap:.0%} of the smaller free space",
        f"  conflict    {best.conflict:.1%} of the walls that both maps see",
    ]
