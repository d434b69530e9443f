"""Placements with scores of a peer's own, turned into an alignment by one rule for all peers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

BOUNDS_SLACK = 0.05  # how far the scale found may leave its bounds
KEPT = 5  # candidates, at the most


class Placement(NamedTuple):
    """A placement of B on A between pixel centres, and the peer's own score of it: at least 0, better when higher."""

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

    The best is accepted where its score reaches `accept_at`. None of the peers says how probable its answer is; the
    confidence is score / (score + accept_at), which keeps their order and is a half where they accept.

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
    within = [one for one in placements if lo <= one.pixels.scale <= hi]
    best = sorted(within, key=lambda one: -one.score)[:KEPT]
    if not best:
        return Alignment(verdict="rejected", reason=nothing, method=method)
    candidates = tuple(
        Candidate.from_pixels(
            one.pixels, a, b, confidence=one.score / (one.score + accept_at), evidence={"score": one.score}
        )
        for one in best
    )
    is_accepted = best[0].score >= accept_at
    told = f"its score is {best[0].score:.3g}, at least {accept_at:.3g} is accepted"
    return Alignment(
        verdict="accepted" if is_accepted else "rejected",
        reason=told,
        method=method,
        candidates=candidates,
        confidence=candidates[0].confidence,
    )
