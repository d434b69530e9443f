"""Algorithm 5: the paper's method, from two maps to the placement of one on the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from rectmerge.alignment import Alignment, Candidate
from rectmerge.analysis.dominant_angle import dominant_angle
from rectmerge.analysis.specks import remove_specks
from rectmerge.errors import InputError, RectMergeError
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.iteration import Match, match_triangles, overlay
from rectmerge.paper.orientation import orthogonal_orientation, smallest_turn
from rectmerge.paper.placing import CanvasError, PlacedImage, ResampleFrom
from rectmerge.paper.rmap import RMap, rmap
from rectmerge.paper.triangles import shared_triangles
from rectmerge.similarity import Similarity

BOUNDS_SLACK = 0.05  # how far the scale found may leave its bounds
RUNAWAY = 2.0  # beyond its bounds and its start, 1, by more than this factor, a scale is not worth another pass
UNINFORMED = 0.5  # the method has no evidence for or against its answer, and says so


class _ConditionError(RectMergeError):
    """A condition of the paper is not met; the message is the reason given to the user."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Paper:
    """The paper's method (Algorithm 5), to the letter as far as the letter can run.

    Parameters
    ----------
    n_rectangles
        Empty spaces looked at for edges (Alg. 3, N).
    tau_cells
        Half the width of a line's region (Alg. 3).
    slope_tolerance_deg
        Lines on facing edges within this are parallel (Alg. 3).
    path_depth
        Length of the series of largest neighbours; 0 as in the paper: as long as the shortest, at least 1.
    inclusive_sides
        Sides one cell too long, as eq. 3 is printed.
    delta_cells
        Tolerance of eq. 8.
    min_area_cells
        Rectangles below this take no part in triangles.
    max_rectangles
        The largest rectangles of each map that take part in triangles.
    swap_sides
        Let eq. 8 also compare w with h, which partners at a quarter turn need. A repair.
    resample_from
        "original": every turn and rescaling reads the map as it was given; "previous": the last image, as printed.
    angle_inside_loop
        Repeat Algorithm 3 in every pass, as the text has it; the listing has it once, before the loop.
    max_iterations
        Passes of the loop before it is given up.
    ratio_tolerance
        A ratio this close to 1 counts as 1.
    clean_specks
        Remove specks before anything else. A repair.
    orientation
        "ransac": Algorithm 3; "projection": the projection profiles of the walls. A repair.

    Notes
    -----
    It cannot tell a wrong merge from a right one: whatever the loop ends with is accepted, with confidence 0.5. Where
    the loop does not end, the answer is a rejection, and the pass whose ratio was nearest to 1 is the candidate. The
    random generator is not used: all combinations are compared instead of sampled. The trace has the figures of every
    pass under ``iterations`` and, under ``ended``, whether the ratio came to 1. Of the turn and the ratio of one pass
    both come from one match, as in the listing; section IV prints a second match after the turn, before the ratio.
    """

    name: ClassVar[str] = "paper"
    n_rectangles: int = 10
    tau_cells: float = 1.5
    slope_tolerance_deg: float = 0.5
    path_depth: int = 0
    inclusive_sides: bool = False
    delta_cells: float = 3.0
    min_area_cells: int = 10
    max_rectangles: int = 30
    swap_sides: bool = False
    resample_from: ResampleFrom = "original"
    angle_inside_loop: bool = False
    max_iterations: int = 10
    ratio_tolerance: float = 0.005
    clean_specks: bool = False
    orientation: Literal["ransac", "projection"] = "ransac"

    def __post_init__(self) -> None:
        for field in ("n_rectangles", "min_area_cells", "max_iterations"):
            if getattr(self, field) < 1:
                raise InputError(f"{field} must be >= 1, got {getattr(self, field)}")
        for field in ("tau_cells", "slope_tolerance_deg", "delta_cells", "path_depth", "ratio_tolerance"):
            if not getattr(self, field) >= 0:
                raise InputError(f"{field} must be >= 0, got {getattr(self, field)}")
        if self.max_rectangles < 3:
            raise InputError(f"max_rectangles must be >= 3, got {self.max_rectangles}")
        if self.resample_from not in ("original", "previous"):
            raise InputError(f'resample_from must be "original" or "previous", got {self.resample_from!r}')
        if self.orientation not in ("ransac", "projection"):
            raise InputError(f'orientation must be "ransac" or "projection", got {self.orientation!r}')

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place map B (the paper's map 2) on map A (map 1), or name the condition that a map does not meet."""
        passes: list[Pass] = []
        try:
            passes.extend(self.passes(a, b, scale=scale))
        except _ConditionError as reason:
            if not passes:
                trace = {"iterations": [], "ended": False}
                return Alignment(verdict="rejected", reason=str(reason), method=self.name, trace=trace)
            return self._answer(a, b, passes, scale, f"the ratio loop stopped: {reason}")
        return self._answer(a, b, passes, scale, self._why_endless(passes))

    def passes(self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float]) -> Iterator[Pass]:
        """Run the loop of Algorithm 5, one pass at a time, until the ratio is 1, a scale repeats, or it is given up.

        Raises
        ------
        RectMergeError
            After the passes that were possible, if a condition of the paper is not met; it says which.
        """
        names = ("A", "B")
        steps: list[Pass] = []
        if self.clean_specks:
            a, b = remove_specks(a), remove_specks(b)
        images = [PlacedImage.of(grid.occupancy) for grid in (a, b)]
        turns = [Turn(0.0), Turn(0.0)]
        for number in range(self.max_iterations):  # Alg. 5, line 9
            if number == 0 or self.angle_inside_loop:
                turns = [self._turn(image, name) for image, name in zip(images, names, strict=True)]  # lines 2-5
                images = [  # lines 6-7
                    _fitting(name, image.turned, turn.angle, self.resample_from)
                    for image, turn, name in zip(images, turns, names, strict=True)
                ]
            found = [self._rmap(image, name) for image, name in zip(images, names, strict=True)]  # lines 10-11
            match = self._match(*found)  # lines 12-13, 15
            rescaled_by = images[1].pose.scale * match.ratio
            placed = overlay(images, match)  # line 18, where the centres belong to these images
            steps.append(Pass(match, placed, (turns[0], turns[1]), tuple(images), tuple(found), rescaled_by))
            yield steps[-1]
            if self._ends(steps[-1]) or _repeats(steps):
                return
            if not min(scale[0], 1) / RUNAWAY <= rescaled_by <= max(scale[1], 1) * RUNAWAY:
                raise _ConditionError(f"map B was to be rescaled by {rescaled_by:.4f}, far outside its bounds")
            images[0] = images[0].turned(match.quarter_turns * math.pi / 2)  # line 14
            images[1] = _fitting("B", images[1].rescaled, match.ratio, self.resample_from)  # line 16

    def _turn(self, image: PlacedImage, name: str) -> Turn:
        """Find Lambda of one map."""
        grid = OccupancyGrid(image.cells)
        found = self._rmap(image, name)
        if self.orientation == "projection":
            return Turn(smallest_turn(-dominant_angle(grid)))
        oriented = orthogonal_orientation(
            found,
            n_rectangles=self.n_rectangles,
            tau_cells=self.tau_cells,
            slope_tolerance_deg=self.slope_tolerance_deg,
            path_depth=self.path_depth or None,
        )
        if oriented is None:
            raise _ConditionError(f"map {name} has no pair of parallel edges on facing sides of an empty space")
        return Turn(oriented.turn, oriented.is_cut)

    def _rmap(self, image: PlacedImage, name: str) -> RMap:
        found = rmap(OccupancyGrid(image.cells).free, inclusive_sides=self.inclusive_sides)
        large = int((found.areas >= self.min_area_cells).sum())
        if large < 3:
            raise _ConditionError(
                f"map {name} has fewer than three rectangles of at least {self.min_area_cells} cells: {large}"
            )
        return found

    def _match(self, first: RMap, second: RMap) -> Match:
        triangles = shared_triangles(
            first.boxes,
            second.boxes,
            delta_cells=self.delta_cells,
            min_area_cells=self.min_area_cells,
            max_rectangles=self.max_rectangles,
            swap_sides=self.swap_sides,
        )
        if triangles is None:
            raise _ConditionError(
                f"no three rectangles of map A have three of map B with sides within {self.delta_cells:g} cells"
            )
        return match_triangles(first, second, triangles)

    def _ends(self, step: Pass) -> bool:
        return abs(step.match.ratio - 1) <= self.ratio_tolerance

    def _why_endless(self, passes: list[Pass]) -> str | None:
        if self._ends(passes[-1]):
            return None
        ratios = ", ".join(f"{step.match.ratio:.4f}" for step in passes)
        why = "the scale repeats" if _repeats(passes) else f"stopped after {_iterations(passes)}"
        return f"the ratio loop does not end, {why}: ratios {ratios}"

    def _answer(
        self,
        a: OccupancyGrid,
        b: OccupancyGrid,
        passes: list[Pass],
        scale: tuple[float, float],
        endless: str | None,
    ) -> Alignment:
        final = passes[-1] if endless is None else min(passes, key=lambda step: abs(math.log(step.match.ratio)))
        lo, hi = scale[0] * (1 - BOUNDS_SLACK), scale[1] * (1 + BOUNDS_SLACK)
        found, refused = final.pixels.scale, endless
        if endless is None and not lo <= found <= hi:
            refused = f"the scale found, {found:.4f}, is outside {scale[0]:g} to {scale[1]:g} by more than 5 %"
        confidence = UNINFORMED if refused is None else 0.0
        return Alignment(
            verdict="accepted" if refused is None else "rejected",
            reason=refused or f"the ratio loop ended after {_iterations(passes)}",
            method=self.name,
            candidates=(Candidate.from_pixels(final.pixels, a, b, confidence=confidence),),
            confidence=confidence,
            trace={"iterations": [step.as_trace() for step in passes], "ended": endless is None},
        )


class Turn(NamedTuple):
    """Lambda of one map in radians, and whether Algorithm 3 left out rectangles of some edge to find it."""

    angle: float
    has_cut_edges: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """One pass of the loop.

    Parameters
    ----------
    match
        What matched.
    pixels
        The placement it gives, from B's pixels to A's.
    turns
        Lambda of both maps.
    images, rmaps
        Both maps as they were matched, and their rectangles.
    scale_after
        How many times larger map 2 is made by this pass and those before it.
    """

    match: Match
    pixels: Similarity
    turns: tuple[Turn, Turn]
    images: tuple[PlacedImage, ...]
    rmaps: tuple[RMap, ...]
    scale_after: float

    def as_trace(self) -> dict[str, Any]:
        """Return the figures of the trace as plain data."""
        return {
            "lambda_a_deg": math.degrees(self.turns[0].angle),
            "lambda_b_deg": math.degrees(self.turns[1].angle),
            "has_cut_edges_a": self.turns[0].has_cut_edges,
            "has_cut_edges_b": self.turns[1].has_cut_edges,
            **self.match.as_trace(),
            "rectangles_a": len(self.rmaps[0]),
            "rectangles_b": len(self.rmaps[1]),
            "cumulative_ratio": self.scale_after,
        }


def _fitting(
    name: str, move: Callable[[float, ResampleFrom], PlacedImage], amount: float, source: ResampleFrom
) -> PlacedImage:
    """Turn or rescale a map's image, or refuse to before it fills the memory."""
    try:
        return move(amount, source)
    except CanvasError as error:
        raise _ConditionError(f"map {name} is too large: {error}") from None


def _iterations(passes: list[Pass]) -> str:
    return f"{len(passes)} iteration{'s' * (len(passes) != 1)}"


def _repeats(passes: list[Pass]) -> bool:
    """Tell whether map 2 has come back to a scale it had before."""
    scales = [1.0] + [step.scale_after for step in passes]
    return any(abs(scales[-1] / before - 1) < 1e-9 for before in scales[:-1])
