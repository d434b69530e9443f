"""The registry of methods (entry points) and `align`, the question every method answers."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Literal, Protocol, cast

import numpy as np

from rectmerge.alignment import Alignment, Method, ScaleReport, ScaleSource, right_resolutions
from rectmerge.errors import InputError, MethodError
from rectmerge.grid import OccupancyGrid
from rectmerge.hints import ByHand, Guess, Hint
from rectmerge.method_fields import with_fields
from rectmerge.similarity import Similarity

GROUP = "rectmerge.methods"
DEFAULT_METHOD = "robust"
FREE_SCALE = (0.5, 2.0)
MOST_SCALE = 10_000.0  # cells of one map per cell of the other: beyond, all of one lies in a cell of the other
COARSE_CELLS = 1e11
BY_HAND = 10.0  # a placement by hand may lie beyond the bounds of the scale by this factor; more is a slip
FARTHEST_CELLS = 1e9  # that a guess or a placement by hand may lie away
EXPECTED_WITHIN = 1.1  # resolutions are trusted to this factor either way first: the same where maps change places
Scale = Literal["auto", "free"] | tuple[float, float] | float


class TakesHints(Method, Protocol):
    """A method that can be told something of the placement."""

    def align_by(
        self,
        hint: Hint | None,
        a: OccupancyGrid,
        b: OccupancyGrid,
        *,
        scale: tuple[float, float],
        rng: np.random.Generator,
    ) -> Alignment:
        """Align with a hint."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Hinted:
    solver: TakesHints
    hint: Hint

    @property
    def name(self) -> str:
        return self.solver.name

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        return self.solver.align_by(self.hint, a, b, scale=scale, rng=rng)


@functools.cache
def available() -> Mapping[str, EntryPoint]:
    """Return the registered methods by name, none of them imported yet; what is installed is looked up once."""
    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda point: point.name)}


def make_method(name: str, **fields: object) -> Method:
    """Make a registered method, with some of its fields set; a text value is read as the field's type.

    A field of a group of fields is called ``GROUP.FIELD``.

    Raises
    ------
    MethodError
        If there is no such method or field, it is no dataclass, or a value does not fit.
    """
    points = available()
    if name not in points:
        raise MethodError(f"unknown method {name!r}; there are: {', '.join(points)}")
    try:
        cls = points[name].load()
    except (ImportError, AttributeError) as error:
        raise MethodError(f"method {name!r} cannot be loaded from {points[name].value}: {error}") from error
    if not (isinstance(cls, type) and dataclasses.is_dataclass(cls)):
        raise MethodError(f"method {name!r}: {points[name].value} is no dataclass; a method is a frozen one")
    return cast(Method, with_fields(cls, name, fields))


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
        What is known of the pixel scale, cells of A per cell of B. "auto": where both maps have a resolution, expect
        their ratio within 10 % and search freely only if that finds nothing; else as "free". "free": 0.5 to 2.
        ``(lo, hi)``: between these. A number: this.
    seed
        Same maps and seed, same answer.
    guess
        About where B lies: (x, y, yaw) of the origin of B's map frame in A's, in its map units and radians; see
        `rectmerge.hints.Guess`. The default method takes one.

    Raises
    ------
    InputError
        If the method or the scale cannot be used, or the method takes no guess.
    """
    solver = make_method(method) if isinstance(method, str) else method
    if guess is not None:
        if not all(abs(number) <= FARTHEST_CELLS * max(1.0, a.cell_size) for number in guess):
            raise InputError(f"guess must be three finite numbers (x, y, yaw) near the maps, got {guess}")
        solver = _hinted(solver, Guess(*guess))
    return _answer(solver, a, b, scale, seed)


def check(
    a: OccupancyGrid,
    b: OccupancyGrid,
    placement: Similarity | Alignment,
    *,
    method: str | Method = DEFAULT_METHOD,
    scale: Scale = "auto",
    seed: int = 0,
) -> Alignment:
    """Judge a placement that somebody made: the same verdict, on the best placement beside it, against all others.

    Parameters
    ----------
    a, b
        The two maps.
    placement
        From B's pixels to A's; or an answer, whose best candidate is judged.
    method, scale, seed
        As in `align`: what the other placements are found by. The placement itself may lie outside the scale's bounds,
        but not by a factor of ten.

    Returns
    -------
    Alignment
        The first candidate is the given placement, made exact; the others are what the search found elsewhere.

    Raises
    ------
    InputError
        If the method or the scale cannot be used, the method judges no placement, or the answer has no candidate.
    """
    if isinstance(placement, Alignment) and not placement.candidates:
        raise InputError(f"the answer has no candidate to judge: {placement.verdict}, {placement.reason}")
    pixels = placement.candidates[0].pixels if isinstance(placement, Alignment) else placement
    if not (1 / MOST_SCALE <= pixels.scale <= MOST_SCALE and max(abs(pixels.tx), abs(pixels.ty)) <= FARTHEST_CELLS):
        raise InputError(f"a placement has a scale of 1/{MOST_SCALE:g} to {MOST_SCALE:g} and lies near A, got {pixels}")
    lo, hi = _search_bounds(scale, _expected_scale(a, b))[0]
    if not lo / BY_HAND <= pixels.scale <= hi * BY_HAND:
        told = (
            f"the placement has a scale of {pixels.scale:g} cells of A per cell of B, far beyond {lo:.4g} to {hi:.4g}"
        )
        raise InputError(f"{told}: correct it, or tell the scale (--scale LO:HI) if it is meant")
    solver = make_method(method) if isinstance(method, str) else method
    return _answer(_hinted(solver, ByHand(pixels)), a, b, scale, seed)


def judges_itself(method: Method) -> bool:
    """Return True if a method judges placements, its own and those of others."""
    return hasattr(method, "align_by")


def _hinted(solver: Method, hint: Hint) -> Method:
    if not judges_itself(solver):
        raise InputError(f"method {solver.name!r} takes neither a guess nor a placement; {DEFAULT_METHOD!r} does")
    return _Hinted(cast("TakesHints", solver), hint)


def _answer(solver: Method, a: OccupancyGrid, b: OccupancyGrid, scale: Scale, seed: int) -> Alignment:
    expected = _expected_scale(a, b)
    started = time.perf_counter()
    for name, grid in (("A", a), ("B", b)):
        _require_near(name, grid)
        if not grid.free.any():
            return Alignment(verdict="rejected", reason=f"map {name} has no free cell", method=solver.name, unit=a.unit)
    bounds, source = _search_bounds(scale, expected)
    found = solver.align(a, b, scale=bounds, rng=np.random.default_rng(seed))
    if source == "resolution" and found.verdict == "rejected":
        found, source = _search_freely(solver, a, b, found, expected or 1.0, seed)
    if source == "given" and not found and expected is not None and not bounds[0] <= expected <= bounds[1]:
        hint = f"the resolutions tell a scale of {expected:.3g}, which was not among those searched"
        found = dataclasses.replace(found, reason=f"{found.reason}; {hint}")
    best = found.candidates[0].pixels.scale if found.candidates else None
    return dataclasses.replace(
        found,
        unit=a.unit,
        scale=ScaleReport(found=best, expected=expected, source=source),
        seconds=time.perf_counter() - started,
    )


def _expected_scale(a: OccupancyGrid, b: OccupancyGrid) -> float | None:
    return None if a.resolution is None or b.resolution is None else b.resolution / a.resolution


def _require_near(name: str, grid: OccupancyGrid) -> None:
    """Refuse a map whose origin is so far away that numbers are too coarse to tell its cells."""
    *at, yaw = grid.origin
    if max(map(abs, at)) > COARSE_CELLS * grid.cell_size or abs(yaw) > COARSE_CELLS:
        raise InputError(
            f"map {name}: its origin {grid.origin} is too far away for cells of {grid.cell_size:g} {grid.unit}; "
            "move it nearer"
        )


def searched_scale(scale: Scale, report: ScaleReport) -> tuple[float, float]:
    """Return the bounds of the pixel scale within which `align` found an answer, from what was asked and reported."""
    return FREE_SCALE if report.source == "search" else _search_bounds(scale, report.expected)[0]


def _search_bounds(scale: Scale, expected: float | None) -> tuple[tuple[float, float], ScaleSource]:
    if scale == "auto" and expected is not None:
        if not 1 / MOST_SCALE <= expected <= MOST_SCALE:
            raise InputError(
                f"the resolutions tell {expected:g} cells of A per cell of B: one is wrong; tell the right one"
            )
        return (expected / EXPECTED_WITHIN, expected * EXPECTED_WITHIN), "resolution"
    if scale in ("auto", "free"):
        return FREE_SCALE, "search"
    try:
        lo, hi = scale if isinstance(scale, tuple) else (float(scale), float(scale))
    except (TypeError, ValueError):
        raise InputError(f'scale must be "auto", "free", (lo, hi) or a number, got {scale!r}') from None
    if not 1 / MOST_SCALE <= lo <= hi <= MOST_SCALE:
        raise InputError(f"scale must satisfy 1/{MOST_SCALE:g} <= lo <= hi <= {MOST_SCALE:g}, got {scale!r}")
    return (lo, hi), "given"


def _search_freely(
    solver: Method, a: OccupancyGrid, b: OccupancyGrid, refused: Alignment, expected: float, seed: int
) -> tuple[Alignment, ScaleSource]:
    """Try every scale where the resolutions' ratio found nothing; keep the refusal unless that is accepted."""
    found = solver.align(a, b, scale=FREE_SCALE, rng=np.random.default_rng(seed))
    if not found:
        return refused, "resolution"
    ratio = found.candidates[0].pixels.scale / expected
    if 1 / EXPECTED_WITHIN <= ratio <= EXPECTED_WITHIN:
        return found, "search"
    hint = f"the maps fit at {ratio:.2f} times the scale their resolutions tell: is one resolution wrong?"
    if a.resolution is not None and b.resolution is not None:
        hint = f"{hint} {right_resolutions(a.resolution, b.resolution, ratio)}"
    return dataclasses.replace(found, reason=f"{found.reason}; {hint}"), "search"
