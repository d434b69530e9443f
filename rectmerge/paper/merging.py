"""Algorithm 5: the paper's method, from two maps to the placement of one on the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from rectmerge.alignment import Alignment, Candidate
from rectmerge.analysis.dominant_angle import dominant_angle
from rectmerge.analysis.specks import remove_specks
from rectmerge.errors import InputError, RectMergeError
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.iteration import Match, Pass, Turn, match_triangles, overlay
from rectmerge.paper.orientation import orthogonal_orientation, smallest_turn
from rectmerge.paper.placed_image import CanvasError, PlacedImage, ResampleFrom
from rectmerge.paper.rmap import RMap, rmap
from rectmerge.paper.triangles import shared_triangles

UNINFORMED = 0.5  # the confidence of a method without evidence for or against its answer
LEAST = {  # values of fields
    **dict.fromkeys(("n_rectangles", "max_edge_points", "min_area_cells", "max_iterations", "runaway_factor"), 1),
    **dict.fromkeys(("tau_cells", "slope_tolerance_deg", "path_depth", "walled_share", "delta_cells"), 0),
    **dict.fromkeys(("max_comparisons", "ratio_tolerance", "scale_slack"), 0),
    "max_rectangles": 3,
}


class _ConditionError(RectMergeError):
    """Condition of the paper that is not met; the message is the reason given to the user."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Paper:
    """The paper's method (Algorithm 5), to the letter as far as the letter can run.

    Parameters
    ----------
    n_rectangles
        Largest rectangles taken as centres of empty spaces. Source: III-B, N between 5 and 10.
    tau_cells
        Half the height of a line's region, tau of Alg. 3. Source: hand, no data.
    slope_tolerance_deg
        Greatest difference of slopes called the same (Alg. 3, lines 22-23). Source: hand, no data.
    path_depth
        Length of the series of largest neighbours; 0: that of the shortest series, at least 1. Source: III-B.
    max_edge_points
        Largest rectangles of an edge that make lines. Source: hand, the count is cubic in them.
    walled_share
        Share of a side along walls for an edge of a map without slanted lines. Source: hand, no data.
    inclusive_sides
        Sides one cell too long, as printed. Source: eq. 3.
    delta_cells
        Tolerance of sides. Source: eq. 8, without a number.
    min_area_cells
        Least area of a rectangle in a triangle. Source: III-C, "smaller than 10 are eliminated".
    max_rectangles
        Largest rectangles of each map that make triangles. Source: hand, no data.
    max_comparisons
        Comparisons of vertices after which the search for triangles stops. Source: hand, about 0.1 s.
    swap_sides
        Also compare w with h in eq. 8, as partners at a quarter turn need. Source: a repair.
    resample_from
        "original": every turn and rescaling reads the map as given; "previous": the last image. Source: Alg. 5, printed
        as "previous".
    angle_inside_loop
        Repeat Algorithm 3 in every pass. Source: the text of III-D; the listing has it once, before the loop.
    max_iterations
        Passes after which the loop is stopped. Source: hand, no data.
    ratio_tolerance
        Greatest difference of a ratio from 1 that counts as 1, unitless. Source: hand, no data.
    runaway_factor
        Factor beyond its bounds and its start, 1, at which a scale stops the loop. Source: hand, no data.
    scale_slack
        Share by which the scale may leave its bounds. Source: the contract of `rectmerge.align`, 5 %.
    clean_specks
        Remove specks first. Source: a repair.
    orientation
        "ransac": Algorithm 3; "projection": the projection profiles of the walls. Source: a repair.

    Notes
    -----
    The method has no verdict: the result of a loop that ends is accepted, with confidence 0.5. If the loop does not
    end, the answer is a rejection, and the pass with the ratio nearest to 1 is the candidate. The random generator is
    not used: all combinations are compared instead of sampled. The trace has the numbers of every pass under
    ``iterations`` and, under ``ended``, if the ratio came to 1. The turn and the ratio of a pass come from one match,
    as in the listing; section IV prints a second match after the turn, before the ratio.
    """

    name: ClassVar[str] = "paper"
    n_rectangles: int = 10
    tau_cells: float = 1.5
    slope_tolerance_deg: float = 0.5
    path_depth: int = 0
    max_edge_points: int = 150
    walled_share: float = 0.5
    inclusive_sides: bool = False
    delta_cells: float = 3.0
    min_area_cells: int = 10
    max_rectangles: int = 30
    max_comparisons: int = 10_000_000
    swap_sides: bool = False
    resample_from: ResampleFrom = "original"
    angle_inside_loop: bool = False
    max_iterations: int = 10
    ratio_tolerance: float = 0.005
    runaway_factor: float = 2.0
    scale_slack: float = 0.05
    clean_specks: bool = False
    orientation: Literal["ransac", "projection"] = "ransac"

    def __post_init__(self) -> None:
        for field, least in LEAST.items():
            if not getattr(self, field) >= least:
                raise InputError(f"{field} must be >= {least}, got {getattr(self, field)}")
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
        images = [PlacedImage.from_cells(grid.occupancy) for grid in (a, b)]
        turns = [Turn(0.0), Turn(0.0)]
        for number in range(self.max_iterations):  # Alg. 5, lines 8-9
            if number == 0 or self.angle_inside_loop:
                turns = [self._turn(image, name) for image, name in zip(images, names, strict=True)]
                images = [  # Alg. 5, lines 6-7
                    _fitting(name, image.turned, turn.angle, self.resample_from)
                    for image, turn, name in zip(images, turns, names, strict=True)
                ]
            rmaps = [self._rmap(image, name) for image, name in zip(images, names, strict=True)]  # Alg. 5, lines 10-11
            match = self._match(*rmaps)
            rescaled_by = images[1].pose.scale * match.ratio
            placed = overlay(images, match)
            steps.append(Pass(match, placed, (turns[0], turns[1]), tuple(images), tuple(rmaps), rescaled_by))
            yield steps[-1]
            if self._ends(steps[-1]) or _repeats(steps):
                return
            lo, hi = min(scale[0], 1) / self.runaway_factor, max(scale[1], 1) * self.runaway_factor
            if not lo <= rescaled_by <= hi:
                raise _ConditionError(f"map B was to be rescaled by {rescaled_by:.4f}, far outside its bounds")
            images[0] = images[0].turned(match.quarter_turns * math.pi / 2)  # Alg. 5, line 14
            images[1] = _fitting("B", images[1].rescaled, match.ratio, self.resample_from)  # Alg. 5, line 16

    def _turn(self, image: PlacedImage, name: str) -> Turn:
        """Return Lambda of a map."""
        grid = OccupancyGrid(image.cells)
        rectangles = self._rmap(image, name)  # Alg. 5, lines 2-3
        if self.orientation == "projection":
            return Turn(smallest_turn(-dominant_angle(grid)))
        oriented = orthogonal_orientation(  # Alg. 5, lines 4-5
            rectangles,
            n_rectangles=self.n_rectangles,
            tau_cells=self.tau_cells,
            slope_tolerance_deg=self.slope_tolerance_deg,
            path_depth=self.path_depth or None,
            max_edge_points=self.max_edge_points,
            walled_share=self.walled_share,
        )
        if oriented is None:
            raise _ConditionError(f"map {name} has no pair of parallel edges on facing sides of an empty space")
        return Turn(oriented.turn, oriented.is_cut)

    def _rmap(self, image: PlacedImage, name: str) -> RMap:
        rectangles = rmap(OccupancyGrid(image.cells).free, inclusive_sides=self.inclusive_sides)
        large = int((rectangles.areas >= self.min_area_cells).sum())
        if large < 3:
            raise _ConditionError(
                f"map {name} has fewer than three rectangles of at least {self.min_area_cells} cells: {large}"
            )
        return rectangles

    def _match(self, first: RMap, second: RMap) -> Match:
        triangles = shared_triangles(  # Alg. 5, line 12
            first.boxes,
            second.boxes,
            delta_cells=self.delta_cells,
            min_area_cells=self.min_area_cells,
            max_rectangles=self.max_rectangles,
            swap_sides=self.swap_sides,
            max_comparisons=self.max_comparisons,
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
        lo, hi = scale[0] * (1 - self.scale_slack), scale[1] * (1 + self.scale_slack)
        ratio, refused = final.pixels.scale, endless
        if endless is None and not lo <= ratio <= hi:
            bounds = f"{scale[0]:g} to {scale[1]:g} by more than {self.scale_slack:.0%}".replace("%", " %")
            refused = f"the scale found, {ratio:.4f}, is outside {bounds}"
        confidence = UNINFORMED if refused is None else 0.0
        return Alignment(
            verdict="accepted" if refused is None else "rejected",
            reason=refused or f"the ratio loop ended after {_iterations(passes)}",
            method=self.name,
            candidates=(Candidate.from_pixels(final.pixels, a, b, confidence=confidence),),
            confidence=confidence,
            trace={"iterations": [step.as_trace() for step in passes], "ended": endless is None},
        )


def _fitting(
    name: str, move: Callable[[float, ResampleFrom], PlacedImage], amount: float, source: ResampleFrom
) -> PlacedImage:
    """Turn or rescale the image of a map; refuse one that would fill the memory."""
    try:
        return move(amount, source)
    except CanvasError as error:
        raise _ConditionError(f"map {name} is too large: {error}") from None


def _iterations(passes: list[Pass]) -> str:
    return f"{len(passes)} iteration{'s' * (len(passes) != 1)}"


def _repeats(passes: list[Pass]) -> bool:
    """Check if map 2 has come back to an earlier scale."""
    scales = [1.0] + [step.scale_after for step in passes]
    return any(abs(scales[-1] / before - 1) < 1e-9 for before in scales[:-1])
