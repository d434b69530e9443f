"""Alignment of two maps by any method, with its hints and the bounds of its scale."""

from __future__ import annotations

import dataclasses
import time
from typing import Literal

import numpy as np

from rectmerge import methods
from rectmerge.alignment import Alignment, Candidate, Method, ScaleReport, ScaleSource, right_resolutions
from rectmerge.derived import derive, derived_kept
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, known_part, map_frame_to_pixels
from rectmerge.hints import ByHand, Guess, Hint, TakesHints
from rectmerge.methods import DEFAULT_METHOD
from rectmerge.similarity import Similarity

FREE_SCALE = (0.5, 2.0)
FRAME_FACTOR = 4.0  # times its known part's area: a larger map is cropped first; by hand, so that usual maps stay whole
MAX_SCALE = 10_000.0  # cells of one map per cell of the other: beyond, one map lies in a single cell of the other
MAX_ORIGIN_CELLS = 1e11  # beyond, floating-point numbers do not resolve single cells
HAND_SCALE_FACTOR = 10.0  # by which a placement by hand may leave the bounds of the scale; more is a typing error
MAX_SHIFT_CELLS = 1e9  # of a guess or a placement by hand
EXPECTED_WITHIN = 1.02  # factor either way within which resolutions are trusted: in 34 of 35 pairs of real robots
DECLARED_WITHIN = 1.15  # within which robots measure wrong; wheels of real robots are up to 12 % off
SURE_BESIDE = 0.95  # confidence asked of what lies between the two; by hand
DOUBTED = "is_beside_resolutions"  # in the evidence of a candidate that the resolutions do not allow
Scale = Literal["auto", "free"] | tuple[float, float] | float


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _HintedMethod:
    """Method with a hint for its search, which is aligned like any other."""

    method: TakesHints
    hint: Hint

    @property
    def name(self) -> str:
        return self.method.name

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        return self.method.align_by(self.hint, a, b, scale=scale, rng=rng)


def align(
    a: OccupancyGrid,
    b: OccupancyGrid,
    *,
    method: str | Method = DEFAULT_METHOD,
    scale: Scale = "auto",
    seed: int = 0,
    guess: tuple[float, float, float] | None = None,
) -> Alignment:
    """Find the similarity that takes map B into map A, or say why there is none.

    Parameters
    ----------
    a, b
        The two maps.
    method
        A registered name, or a method.
    scale
        Pixel scale to search, cells of A per cell of B. "auto": where both maps have a resolution, within 2 % of their
        ratio, and further only if that finds nothing: up to 15 % off an answer is accepted from 0.95 on, beyond it is
        a candidate, with the question which resolution is wrong; else as "free". "free": 0.5 to 2.
        ``(lo, hi)``: between these. A number: this.
    seed
        Same maps and seed, same answer.
    guess
        Approximate place of B: (x, y, yaw) of the origin of B's map frame in A's, in its map units and radians; see
        `rectmerge.hints.Guess`. The default method takes one.

    Raises
    ------
    InputError
        If the method or the scale cannot be used, or the method takes no guess.
    """
    chosen = methods.make_method(method) if isinstance(method, str) else method
    if guess is not None:
        if not all(abs(number) <= MAX_SHIFT_CELLS * max(1.0, a.cell_size) for number in guess):
            raise InputError(f"guess must be three finite numbers (x, y, yaw) near the maps, got {guess}")
        chosen = _with_hint(chosen, Guess(*guess))
    parts = derive(a, _without_frame, lambda: _without_frame(a)), derive(b, _without_frame, lambda: _without_frame(b))
    alignment = _align(chosen, *parts, scale, seed)
    return alignment if parts == (a, b) else _on_whole_maps(alignment, a, b)


def check(
    a: OccupancyGrid,
    b: OccupancyGrid,
    placement: Similarity | Alignment,
    *,
    method: str | Method = DEFAULT_METHOD,
    scale: Scale = "auto",
    seed: int = 0,
) -> Alignment:
    """Judge a placement by hand: refine it, and give the verdict on it against all other placements.

    Parameters
    ----------
    a, b
        The two maps.
    placement
        From B's pixels to A's; or an alignment, whose best candidate is judged.
    method, scale, seed
        As in `align`, for the search of the other placements. The placement itself may lie outside the scale's bounds,
        but not by a factor of ten.

    Returns
    -------
    Alignment
        The first candidate is the given placement, refined; the others are the results of the search elsewhere.

    Raises
    ------
    InputError
        If the method or the scale cannot be used, the method judges no placement, or the alignment has no candidate.
    """
    if isinstance(placement, Alignment) and not placement.candidates:
        raise InputError(f"the answer has no candidate to judge: {placement.verdict}, {placement.reason}")
    pixels = placement.candidates[0].pixels if isinstance(placement, Alignment) else placement
    if not (1 / MAX_SCALE <= pixels.scale <= MAX_SCALE and max(abs(pixels.tx), abs(pixels.ty)) <= MAX_SHIFT_CELLS):
        raise InputError(f"a placement has a scale of 1/{MAX_SCALE:g} to {MAX_SCALE:g} and lies near A, got {pixels}")
    lo, hi = _search_bounds(scale, _expected_scale(a, b))[0]
    if not lo / HAND_SCALE_FACTOR <= pixels.scale <= hi * HAND_SCALE_FACTOR:
        fault = (
            f"the placement has a scale of {pixels.scale:g} cells of A per cell of B, far beyond {lo:.4g} to {hi:.4g}"
        )
        raise InputError(f"{fault}: correct it, or give the scale (--scale LO:HI) if it is meant")
    chosen = methods.make_method(method) if isinstance(method, str) else method
    return _align(_with_hint(chosen, ByHand(pixels)), a, b, scale, seed)


def _without_frame(grid: OccupancyGrid) -> OccupancyGrid:
    """Return the known part of a map that lies in a large frame of unknown cells, which would only cost time."""
    part = known_part(grid)
    return part if grid.occupancy.size > FRAME_FACTOR * part.occupancy.size else grid


def _on_whole_maps(alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Alignment:
    """Return an alignment of parts of two maps, in the same map frames, with the pixels of the whole maps."""
    candidates = tuple(
        dataclasses.replace(each, pixels=map_frame_to_pixels(each.b_to_a, a, b)) for each in alignment.candidates
    )
    return dataclasses.replace(alignment, candidates=candidates)


def judges_itself(method: Method) -> bool:
    """Return whether a method judges placements, its own and those of others."""
    return isinstance(method, TakesHints)


def _with_hint(method: Method, hint: Hint) -> Method:
    if not isinstance(method, TakesHints):
        raise InputError(f"method {method.name!r} takes neither a guess nor a placement; {DEFAULT_METHOD!r} does")
    return _HintedMethod(method, hint)


def _align(method: Method, a: OccupancyGrid, b: OccupancyGrid, scale: Scale, seed: int) -> Alignment:
    expected = _expected_scale(a, b)
    started = time.perf_counter()
    for name, grid in (("A", a), ("B", b)):
        _require_near(name, grid)
        if not grid.free.any():
            return Alignment(verdict="rejected", reason=f"map {name} has no free cell", method=method.name, unit=a.unit)
    bounds, source = _search_bounds(scale, expected)
    with derived_kept():
        alignment = method.align(a, b, scale=bounds, rng=np.random.default_rng(seed))
        if source == "resolution" and expected is not None:
            if alignment.verdict == "rejected":
                alignment, source = _search_wider(method, a, b, alignment, expected, seed)
            is_judge = judges_itself(method) or isinstance(method, _HintedMethod)
            alignment = _beside_resolutions(alignment, expected, a, b, is_judge=is_judge)
    if source == "given" and not alignment and expected is not None and not bounds[0] <= expected <= bounds[1]:
        note = f"the resolutions give a scale of {expected:.3g}, which was not searched"
        alignment = dataclasses.replace(alignment, reason=f"{alignment.reason}; {note}")
    best = alignment.candidates[0].pixels.scale if alignment.candidates else None
    return dataclasses.replace(
        alignment,
        unit=a.unit,
        scale=ScaleReport(found=best, expected=expected, source=source),
        seconds=time.perf_counter() - started,
    )


def _expected_scale(a: OccupancyGrid, b: OccupancyGrid) -> float | None:
    return None if a.resolution is None or b.resolution is None else b.resolution / a.resolution


def _require_near(name: str, grid: OccupancyGrid) -> None:
    """Refuse a map whose origin is so far away that floating-point numbers do not resolve its cells."""
    *at, yaw = grid.origin
    if max(map(abs, at)) > MAX_ORIGIN_CELLS * grid.cell_size or abs(yaw) > MAX_ORIGIN_CELLS:
        raise InputError(
            f"map {name}: its origin {grid.origin} is too far away for cells of {grid.cell_size:g} {grid.unit}; "
            "move it nearer"
        )


def searched_scale(scale: Scale, report: ScaleReport) -> tuple[float, float]:
    """Return the bounds of the pixel scale within which `align` searched, from its argument and its report."""
    if report.source != "search" or scale == "free":
        return _search_bounds(scale, report.expected)[0]
    near, *_ = [FREE_SCALE] if report.expected is None else _wider_bounds(report.expected)
    is_near = report.found is not None and near[0] <= report.found <= near[1]
    return near if is_near else FREE_SCALE


def _search_bounds(scale: Scale, expected: float | None) -> tuple[tuple[float, float], ScaleSource]:
    if scale == "auto" and expected is not None:
        if not 1 / MAX_SCALE <= expected <= MAX_SCALE:
            raise InputError(
                f"the resolutions give {expected:g} cells of A per cell of B: one is wrong; give the right one"
            )
        return (expected / EXPECTED_WITHIN, expected * EXPECTED_WITHIN), "resolution"
    if scale in ("auto", "free"):
        return FREE_SCALE, "search"
    try:
        lo, hi = scale if isinstance(scale, tuple) else (float(scale), float(scale))
    except (TypeError, ValueError):
        raise InputError(f'scale must be "auto", "free", (lo, hi) or a number, got {scale!r}') from None
    if not 1 / MAX_SCALE <= lo <= hi <= MAX_SCALE:
        raise InputError(f"scale must satisfy 1/{MAX_SCALE:g} <= lo <= hi <= {MAX_SCALE:g}, got {scale!r}")
    return (lo, hi), "given"


def _search_wider(
    method: Method, a: OccupancyGrid, b: OccupancyGrid, refused: Alignment, expected: float, seed: int
) -> tuple[Alignment, ScaleSource]:
    """Search far beside the ratio of the resolutions where it gave nothing; keep the refusal unless that finds more.

    What fits at the expected scale has been judged already, by a search that knew it.
    """
    for bounds in _wider_bounds(expected):
        alignment = method.align(a, b, scale=bounds, rng=np.random.default_rng(seed))
        if alignment and not _is_near(alignment.candidates[0], expected, EXPECTED_WITHIN):
            return alignment, "search"
    return refused, "resolution"


def _wider_bounds(expected: float) -> list[tuple[float, float]]:
    """List the bounds of scales to search where the resolutions gave nothing."""
    near = expected / DECLARED_WITHIN, expected * DECLARED_WITHIN
    return [FREE_SCALE] if FREE_SCALE[0] <= near[0] and near[1] <= FREE_SCALE[1] else [near, FREE_SCALE]


def _is_near(candidate: Candidate, expected: float, factor: float) -> bool:
    """Test whether a candidate's scale is within a factor of the expected one, either way."""
    return 1 / factor <= candidate.pixels.scale / expected <= factor


def _beside_resolutions(
    alignment: Alignment, expected: float, a: OccupancyGrid, b: OccupancyGrid, *, is_judge: bool
) -> Alignment:
    """Return an answer as far as the resolutions allow it: beside them it has to be surer, far from them it is refused.

    Robots measure distances wrong by up to a tenth or so; beyond, one resolution is wrong, and which one a person has
    to say. The answer of a method that is no judge is left alone: its judge is asked next.
    """
    if not (alignment and is_judge) or _is_near(alignment.candidates[0], expected, EXPECTED_WITHIN):
        return alignment
    found = alignment.candidates[0].pixels.scale
    said = f"the files' resolutions say {expected:.4g}, the walls {found:.4g}"
    if not _is_near(alignment.candidates[0], expected, DECLARED_WITHIN):
        note = f"they fit at {found / expected:.2f} times the scale of their resolutions: is one resolution wrong?"
        if a.resolution is not None and b.resolution is not None:
            note = f"{note} {right_resolutions(a.resolution, b.resolution, found / expected)}"
        return _doubted(alignment, expected, f"{alignment.reason}; but {said}: {note}")
    if alignment.confidence < SURE_BESIDE:
        asked = f"there {SURE_BESIDE:.0%} is asked, and the walls give {alignment.confidence:.1%}"
        return _doubted(
            alignment, expected, f"{alignment.reason}; but {said}: {asked}; look at the overlay, or widen --scale"
        )
    return dataclasses.replace(alignment, reason=f"{alignment.reason}; {said}")


def _doubted(alignment: Alignment, expected: float, reason: str) -> Alignment:
    """Return an accepted answer as candidates; those beside the resolutions have even odds at most."""

    def doubt(candidate: Candidate) -> Candidate:
        if _is_near(candidate, expected, EXPECTED_WITHIN):
            return candidate
        evidence = {**candidate.evidence, DOUBTED: 1.0}
        return dataclasses.replace(candidate, confidence=min(0.5, candidate.confidence), evidence=evidence)

    candidates = tuple(map(doubt, alignment.candidates))
    return dataclasses.replace(
        alignment,
        verdict="ambiguous",
        method_verdict=alignment.verdict,
        reason=reason,
        candidates=candidates,
        confidence=candidates[0].confidence,
    )
