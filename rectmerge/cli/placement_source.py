"""Where map B is laid on map A: as the method finds it, near a guess, or as somebody says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rectmerge.alignment import Alignment, Candidate, Method
from rectmerge.analysis.overlap import cells_of
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.methods import Scale, align, check
from rectmerge.results.alignment_json import AlignmentFile
from rectmerge.results.saved_alignment import SavedAlignment
from rectmerge.similarity import Similarity

SAMPLED_CELLS = 2000
REACH, LEAST_REACH_CELLS = 0.1, 5.0  # what a hand misses: a share of the RMS radius of B's free space, and at least


@dataclass(frozen=True, slots=True, kw_only=True)
class Placing:
    """What somebody says of the placement; nothing where the method is to find it.

    Parameters
    ----------
    guess
        About (x, y, yaw) of B's map frame in A's, map units of A and radians.
    pixels
        From B's pixels to A's, exactly.
    earlier
        An ``alignment.json``, or its folder: the placement is that of its answer, between the map frames.
    candidate
        Which candidate is taken, 1 the best, of the earlier answer or of this one, whatever the verdict.

    Raises
    ------
    InputError
        If more than one of guess, pixels and earlier is told, or a candidate beside pixels.
    """

    guess: tuple[float, float, float] | None = None
    pixels: Similarity | None = None
    earlier: Path | None = None
    candidate: int | None = None

    def __post_init__(self) -> None:
        named = {"--guess": self.guess, "--pixels": self.pixels, "--from": self.earlier}
        told = [name for name, value in named.items() if value is not None]
        if len(told) > 1:
            raise InputError(f"{' and '.join(told)} exclude each other")
        if self.candidate is not None and self.pixels is not None:
            raise InputError("--pixels and --candidate exclude each other")

    def answer(
        self, a: OccupancyGrid, b: OccupancyGrid, *, method: Method, scale: Scale = "auto", seed: int = 0
    ) -> Alignment:
        """Place B on A.

        A placement that was told is taken as it is, and accepted; the reason says what the walls make of it.

        Raises
        ------
        InputError
            If the earlier answer cannot be read or used, there is no such candidate, or the method takes no hint.
        """
        if self.earlier is not None:
            pixels, by = self._earlier_pixels(a, b), self._earlier_name()
        elif self.pixels is not None:
            pixels, by = self.pixels, "placed by hand"
        else:
            found = align(a, b, method=method, scale=scale, seed=seed, guess=self.guess)
            return found if self.candidate is None else _chosen(found, self.candidate)
        return _as_told(check(a, b, pixels, method=method, scale=scale, seed=seed), a, b, pixels, by)

    def _earlier_name(self) -> str:
        if self.candidate is None:
            return "placed as an earlier merge did"
        return f"placed as candidate {self.candidate} of an earlier merge"

    def _earlier_pixels(self, a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
        saved = SavedAlignment.from_file(AlignmentFile.read(self.earlier or Path()))
        if self.candidate is None and saved.verdict != "accepted":
            raise InputError(
                f"{self.earlier}: {saved.verdict}; name one of its {len(saved.candidates)} candidates by --candidate"
            )
        transform = saved.candidate(self.candidate or 1)
        if transform.unit != a.unit:
            raise InputError(
                f"{self.earlier}: places map B in {transform.unit}, but map A is in {a.unit}; give --resolution-a"
            )
        return map_frame_to_pixels(transform.b_to_a, a, b)


def parse_guess(text: str) -> tuple[float, float, float]:
    """Read ``x,y,yaw``.

    Examples
    --------
    >>> parse_guess("1.5,-2,0.1")
    (1.5, -2.0, 0.1)
    """
    x, y, yaw = _numbers(text, (3,), "x,y,yaw: metres and radians in A's map frame")
    return x, y, yaw


def parse_pixels(text: str) -> Similarity:
    """Read ``a,b,tx,ty``, or the matrix ``a,-b,tx,b,a,ty``, from B's pixels to A's.

    Examples
    --------
    >>> parse_pixels("0,1,5,6") == parse_pixels("0,-1,5,1,0,6")
    True
    """
    numbers = _numbers(text, (4, 6), "a,b,tx,ty, or the six numbers of a matrix a,-b,tx,b,a,ty")
    if len(numbers) == 4:
        a, b, tx, ty = numbers
        numbers = [a, -b, tx, b, a, ty]
    return Similarity.from_matrix(np.reshape(numbers, (2, 3)))


def moved_cells(b: OccupancyGrid, told: Similarity, exact: Similarity) -> float:
    """RMS distance, in A's cells, between where two placements put B's free space."""
    cells = cells_of(b.free, SAMPLED_CELLS)[:, ::-1]
    return float(np.sqrt(((told.apply(cells) - exact.apply(cells)) ** 2).sum(axis=1).mean()))


def reach_cells(b: OccupancyGrid, exact: Similarity) -> float:
    """How far, in A's cells, a placement by hand may be moved and still be the same, made exact."""
    cells = cells_of(b.free, SAMPLED_CELLS)
    radius = float(np.sqrt(((cells - cells.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return max(LEAST_REACH_CELLS, REACH * radius * exact.scale)


def _numbers(text: str, counts: Sequence[int], what: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise InputError(f"{text!r} is not {what}")
    return numbers


def _chosen(found: Alignment, number: int) -> Alignment:
    """Take a candidate whatever the verdict; it comes first, the others stay in their order."""
    if not 1 <= number <= len(found.candidates):
        raise InputError(f"there is no candidate {number}: {found.verdict} with {len(found.candidates)} candidates")
    if found and number == 1:
        return found
    taken = found.candidates[number - 1]
    rest = tuple(other for other in found.candidates if other is not taken)
    return replace(
        found,
        verdict="accepted",
        reason=f"candidate {number}, chosen by hand; unaided the verdict is: {found.verdict}, {found.reason}",
        candidates=(taken, *rest),
        confidence=taken.confidence,
        scale=replace(found.scale, found=taken.pixels.scale),
    )


def _as_told(judged: Alignment, a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity, by: str) -> Alignment:
    """Take a placement exactly as told; what the walls make of it stands in the reason."""
    told = Candidate.from_pixels(pixels, a, b, confidence=judged.confidence)
    return replace(
        judged,
        verdict="accepted",
        reason=f"{by}; the walls say: {judged.verdict}, {judged.reason}",
        candidates=(told, *judged.candidates[1:]),
        scale=replace(judged.scale, found=pixels.scale, source="given"),
    )
