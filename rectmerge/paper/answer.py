"""Answer of the paper's method: a verdict and a reason from the passes of its loop."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.iteration import Pass, has_repeated

UNINFORMED = 0.5  # the confidence of a method without evidence for or against its answer


def answer(
    name: str,
    maps: tuple[OccupancyGrid, OccupancyGrid],
    passes: Sequence[Pass],
    unmet: str | None,
    scale: tuple[float, float],
    *,
    ratio_tolerance: float,
    scale_slack: float,
) -> Alignment:
    """Accept the last pass if its ratio is 1, else reject with the pass whose ratio is nearest to 1 as the candidate.

    Parameters
    ----------
    name
        The name of the method.
    maps
        Maps A and B.
    passes
        Every pass of the loop.
    unmet
        The condition that stopped the loop, or None.
    scale
        Bounds of the pixel scale.
    ratio_tolerance
        Greatest difference of a ratio from 1 that counts as 1.
    scale_slack
        Share by which the scale may leave its bounds.
    """
    ended = unmet is None and passes[-1].is_final(ratio_tolerance)
    trace = {"iterations": [step.as_trace() for step in passes], "ended": ended}
    if not passes:
        return Alignment(verdict="rejected", reason=str(unmet), method=name, trace=trace)
    rescaling = [step for step in passes if step.is_rescaling] or passes
    best = rescaling[-1] if ended else min(rescaling, key=lambda step: abs(math.log(step.match.ratio)))
    refusal = _refusal(passes, unmet, ended) or _out_of_bounds(best.pixels.scale, scale, scale_slack)
    confidence = 0.0 if refusal else UNINFORMED
    return Alignment(
        verdict="rejected" if refusal else "accepted",
        reason=refusal or f"the ratio loop ended after {_iterations(passes)}",
        method=name,
        candidates=(Candidate.from_pixels(best.pixels, *maps, confidence=confidence),),
        confidence=confidence,
        trace=trace,
    )


def _refusal(passes: Sequence[Pass], unmet: str | None, ended: bool) -> str | None:
    if ended:
        return None
    if unmet is not None:
        return f"the ratio loop stopped: {unmet}"
    rescaling = [step for step in passes if step.is_rescaling]
    ratios = [step.match.ratio for step in rescaling]
    is_cycle = has_repeated([1.0, *(step.scale_after for step in rescaling)])
    why = "the scale repeats" if is_cycle else f"stopped after {_iterations(passes)}"
    return f"the ratio loop does not end, {why}: ratios {', '.join(f'{ratio:.4f}' for ratio in ratios)}"


def _out_of_bounds(found: float, scale: tuple[float, float], slack: float) -> str | None:
    if scale[0] * (1 - slack) <= found <= scale[1] * (1 + slack):
        return None
    return f"the scale found, {found:.4f}, is outside {scale[0]:g} to {scale[1]:g} by more than {100 * slack:g} %"


def _iterations(passes: Sequence[Pass]) -> str:
    count = passes[-1].iteration
    return f"{count} iteration{'s' * (count != 1)}"
