"""Summary of an alignment as lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from rectmerge.alignment import Alignment, Candidate, Certificate
from rectmerge.analysis.displacement import displacement_cells, hand_tolerance_cells
from rectmerge.elastic.bend import Bend
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

DOUBTFUL_CONFIDENCE = 0.9  # an accepted alignment of less asks for a look at the pictures
DOUBTFUL_CONFLICT = 0.1  # so does one of more: of bent maps, rightly placed, some walls still contradict each other
MAX_LISTED = 5  # candidates
COLUMNS = ("candidate", "confidence", "rotation", "scale", "overlap", "conflict", "picture")


def describe(
    alignment: Alignment,
    files: Sequence[Path] = (),
    certificate: Certificate | None = None,
    *,
    bend: Bend | None = None,
    is_given: bool = False,
    is_shaded: bool = False,
) -> str:
    """Describe an alignment: the verdict, the best candidate, and the files that were written.

    Parameters
    ----------
    alignment, files, certificate
        The alignment, the files that were written, and the certificate by ``--certify``.
    bend
        The bend of map B, accepted or refused; None where it was not tried.
    is_given
        Whether the user placed B.
    is_shaded
        Whether the merged map has other values than free, occupied and unknown.
    """
    lines = [f"{alignment.verdict}: {alignment.reason}", f"  method      {alignment.method}, {alignment.seconds:.2f} s"]
    if alignment or is_given:
        lines += [] if alignment else ["  the placement as it was judged:"]
        lines += _describe_candidate(alignment, alignment.candidates[0]) if alignment.candidates else []
    elif alignment.candidates:
        lines += _list_candidates(alignment, files)
    lines += _doubts(alignment) if alignment and files and not bend else []
    if bend is not None:
        lines.append(f"  unbent      {'' if bend else 'no: '}{bend.reason}")
    if certificate is not None:
        lines.append(f"  certified   {certificate}")
    if is_shaded:
        lines.append("  shades      in mode raw; costmaps take what is below lethal_cost_threshold, 100, for free")
    if files:
        lines.append(f"  written     {files[0].parent}: {', '.join(file.name for file in files)}")
    return "\n".join(lines)


def describe_check(alignment: Alignment, b: OccupancyGrid, placement: Similarity) -> list[str]:
    """Describe the refinement of a placement by hand: its displacement, the option to merge, a better candidate."""
    if not alignment.candidates:
        return []
    best, *others = alignment.candidates
    moved = displacement_cells(b, placement, best.pixels)
    is_near = moved <= hand_tolerance_cells(b, best.pixels)
    if is_near:
        lines = [f"  made exact  by {moved:.1f} cells of A"]
    elif alignment:
        lines = [f"  moved       by {moved:.1f} cells of A, to where the walls agree"]
    else:
        lines = [f"  not exact   nothing fits near there: what was judged lies {moved:,.0f} cells of A away"]
    if alignment or is_near:
        lines.append(f"  to merge    {_as_option(best.pixels)}")
    better = [other for other in others if round(other.confidence, 2) > round(best.confidence, 2)]
    if better:
        away, number = min(
            (displacement_cells(b, placement, other.pixels), alignment.candidates.index(other)) for other in better
        )
        nearest = alignment.candidates[number]
        title = f"candidate {number + 1}, {away:,.0f} cells of A away, confidence {nearest.confidence:.2f}"
        lines.append(f"  better      {title}: {_as_option(nearest.pixels)}")
    return lines


def _as_option(pixels: Similarity) -> str:
    (a, _, tx), (b, _, ty) = pixels.matrix.tolist()
    return f"--pixels={a:.9g},{b:.9g},{tx:.9g},{ty:.9g}"


def _doubts(alignment: Alignment) -> list[str]:
    """Ask for a look at the pictures of an accepted alignment where it or the merged map is doubtful."""
    lines = []
    if alignment.confidence < DOUBTFUL_CONFIDENCE:
        lines.append("  look at     overlay.png before using the map: the method is not sure")
    if alignment.candidates[0].conflict > DOUBTFUL_CONFLICT:
        lines.append("  look at     overlay.png and conflict.png before driving by the map: where the maps contradict")
        lines.append("              each other, walls stand double or break off")
    return lines


def _list_candidates(alignment: Alignment, files: Sequence[Path]) -> list[str]:
    """List the candidates of an alignment that is not accepted, a line each, and the option to take one."""
    pictures = {file.name for file in files}
    rows = [COLUMNS]
    for number, candidate in enumerate(alignment.candidates[:MAX_LISTED], start=1):
        shares = f"{candidate.overlap:.0%}", f"{candidate.conflict:.1%}"
        picture = f"overlay_{number}.png"
        shown = picture if picture in pictures else "-"
        values = f"{candidate.confidence:.2f}", _rotation(candidate), f"{candidate.pixels.scale:.4f}"
        rows.append((str(number), *values, *shares, shown))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  " + "  ".join(map(str.rjust, row, widths)) for row in rows]
    if alignment.scale.expected is not None:
        lines.append(f"  scale       {alignment.scale.expected:.4f} cells of A per cell of B by the resolutions")
    return [*lines, "  to take one look at its picture, and add --candidate K --force to the command"]


def _rotation(candidate: Candidate) -> str:
    return f"{math.degrees(math.remainder(candidate.b_to_a.angle, math.tau)):+.2f} deg"


def _describe_candidate(alignment: Alignment, best: Candidate) -> list[str]:
    expected = alignment.scale.expected
    ratio = "" if expected is None else f", {expected:.4f} by the resolutions"
    return [
        f"  confidence  {best.confidence:.2f}",
        f"  scale       {best.pixels.scale:.4f} cells of A per cell of B{ratio}",
        f"  rotation    {_rotation(best)}, counter-clockwise from B to A",
        f"  shift       {best.b_to_a.tx:+.2f}, {best.b_to_a.ty:+.2f} {alignment.unit}",
        f"  overlap     {best.overlap:.0%} of the smaller free space",
        f"  conflict    {best.conflict:.1%} of the walls that both maps see",
    ]
