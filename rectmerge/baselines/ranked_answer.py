"""Scored placements of a baseline turned into an alignment, by one rule for all baselines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

BOUNDS_SLACK = 0.05  # share by which the scale of an answer may leave its bounds
MAX_CANDIDATES = 5


class Placement(NamedTuple):
    """A placement of B on A between pixel centres, and the baseline's score: at least 0, better when higher."""

    pixels: Similarity
    score: float


def answer(
    method: str,
    a: OccupancyGrid,
    b: OccupancyGrid,
    placements: Sequence[Placement],
    *,
    accept_at: float,
    scale: tuple[float, float],
    nothing: str,
) -> Alignment:
    """Answer with the placements of the highest scores.

    The best is accepted where its score reaches `accept_at`. No baseline has a probability of its answer; the
    confidence is score / (score + accept_at), which keeps the order of the scores and is a half at the threshold.

    Parameters
    ----------
    method
        The method's name.
    a, b
        The two maps.
    placements
        In any order.
    accept_at
        The least score, above 0, that is accepted.
    scale
        Bounds of the pixel scale; placements further outside than 5 % do not count.
    nothing
        The reason where no placement is left.
    """
    lo, hi = scale[0] * (1 - BOUNDS_SLACK), scale[1] * (1 + BOUNDS_SLACK)
    within = [placement for placement in placements if lo <= placement.pixels.scale <= hi]
    best = sorted(within, key=lambda placement: -placement.score)[:MAX_CANDIDATES]
    if not best:
        return Alignment(verdict="rejected", reason=nothing, method=method)
    candidates = tuple(
        Candidate.from_pixels(pixels, a, b, confidence=score / (score + accept_at), evidence={"score": score})
        for pixels, score in best
    )
    is_accepted = best[0].score >= accept_at
    return Alignment(
        verdict="accepted" if is_accepted else "rejected",
        reason=f"its score is {best[0].score:.3g}, at least {accept_at:.3g} is accepted",
        method=method,
        candidates=candidates,
        confidence=candidates[0].confidence,
    )
