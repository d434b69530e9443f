"""An answer in lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rectmerge.alignment import Alignment, Candidate
    from rectmerge.robust.certificate import Certificate

DOUBTFUL = 0.9  # below this confidence a yes asks to be looked at


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
    if found.candidates:
        if not found:
            best = f"best guess of {len(found.candidates)}, not to be used unseen"
            lines.append(f"  the {'placement as it was judged' if is_given else best}:")
        lines += _describe_candidate(found, found.candidates[0])
    if found and found.confidence < DOUBTFUL:
        lines.append("  look at     overlay.png before using the map: the method is not sure")
    if certificate is not None:
        lines.append(f"  certified   {certificate}")
    if is_shaded:
        lines.append("  shades      in mode raw; costmaps take what is below lethal_cost_threshold, 100, for free")
    if files:
        lines.append(f"  written     {files[0].parent}: {', '.join(file.name for file in files)}")
    return "\n".join(lines)


def describe_check(found: Alignment, moved_cells: float) -> list[str]:
    """Tell how far a placement by hand was moved to be exact, and its numbers to be pasted."""
    if not found.candidates:
        return []
    (a, _, tx), (b, _, ty) = found.candidates[0].pixels.matrix.tolist()
    return [
        f"  made exact  by {moved_cells:.1f} cells of A",
        f"  to merge    --pixels={a:.9g},{b:.9g},{tx:.9g},{ty:.9g}",
    ]


def _describe_candidate(found: Alignment, best: Candidate) -> list[str]:
    expected = found.scale.expected
    ratio = "" if expected is None else f", {expected:.4f} by the resolutions"
    turn = math.degrees(math.remainder(best.b_to_a.angle, math.tau))
    return [
        f"  confidence  {best.confidence:.2f}",
        f"  scale       {best.pixels.scale:.4f} cells of A per cell of B{ratio}",
        f"  rotation    {turn:+.2f} deg, counter-clockwise from B to A",
        f"  shift       {best.b_to_a.tx:+.2f}, {best.b_to_a.ty:+.2f} {found.unit}",
        f"  overlap     {best.overlap:.0%} of the smaller free space",
        f"  conflict    {best.conflict:.1%} of the walls that both maps see",
    ]
