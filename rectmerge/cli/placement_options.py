"""Options by which a user places map B, or helps the method to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.aligning import Scale
    from rectmerge.alignment import Alignment, Method
    from rectmerge.grid import OccupancyGrid
    from rectmerge.similarity import Similarity

GuessText = Annotated[
    str | None,
    typer.Option("--guess", metavar="X,Y,YAW", help="Approximate place of B's frame in A's: metres, radians."),
]
CandidateNumber = Annotated[
    int | None, typer.Option("--candidate", min=1, metavar="K", help="Take this candidate, whatever the verdict.")
]
PixelsText = Annotated[
    str | None, typer.Option("--pixels", metavar="A,B,TX,TY", help="Place B by hand: from its pixels to A's.")
]
Earlier = Annotated[
    Path | None,
    typer.Option(
        "--from",
        metavar="ALIGNMENT.json",
        help="Place B as an earlier merge did; of more than two maps, take a fleet.json's answers and ask what is new.",
    ),
]

Unchecked = Annotated[
    bool,
    typer.Option(
        "--unchecked", metavar="", help="Act on the method's own verdict, without the check of `rectmerge check`."
    ),
]


@dataclass(frozen=True, kw_only=True)
class PlacementOptions:
    """Options on the placement; the method finds it where none is given.

    Parameters
    ----------
    guess
        Approximate (x, y, yaw) of B's map frame in A's, map units of A and radians.
    candidate
        Number of the candidate to accept, 1 the best: of the earlier merge if there is one, else of this alignment.
    pixels
        Placement from B's pixels to A's.
    earlier
        An ``alignment.json`` or its folder: B is placed as there, between the map frames.
    unchecked
        Act on the method's own verdict; else its answer is put to the judge (`rectmerge.judging.confirm`).

    Raises
    ------
    InputError
        If more than one of guess, pixels and earlier is given, or a candidate with pixels, or a text cannot be read.
    """

    guess: GuessText = None
    candidate: CandidateNumber = None
    pixels: PixelsText = None
    earlier: Earlier = None
    unchecked: Unchecked = False

    def __post_init__(self) -> None:
        options = {"--guess": self.guess, "--pixels": self.pixels, "--from": self.earlier}
        given = [name for name, value in options.items() if value is not None]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} exclude each other")
        if self.candidate is not None and self.pixels is not None:
            raise InputError("--pixels and --candidate exclude each other")
        if self.guess is not None:
            parse_guess(self.guess)
        if self.pixels is not None:
            parse_pixels(self.pixels)

    def align(self, a: OccupancyGrid, b: OccupancyGrid, *, method: Method, scale: Scale, seed: int) -> Alignment:
        """Align B with A; a given placement is accepted as it is, and the reason holds the verdict of the method.

        Raises
        ------
        InputError
            If the earlier merge cannot be read or used, there is no such candidate, or the method takes no hint.
        """
        from rectmerge.aligning import align, check
        from rectmerge.judging import confirm

        if self.pixels is None and self.earlier is None:
            guess = None if self.guess is None else parse_guess(self.guess)
            alignment = align(a, b, method=method, scale=scale, seed=seed, guess=guess)
            if self.candidate is not None:
                return alignment.with_candidate(self.candidate)
            return alignment if self.unchecked else confirm(a, b, alignment, method=method, scale=scale, seed=seed)
        pixels, source = self._given_placement(a, b)
        judged = check(a, b, pixels, method=method, scale=scale, seed=seed)
        return judged.with_placement(pixels, a, b, source=source)

    def _given_placement(self, a: OccupancyGrid, b: OccupancyGrid) -> tuple[Similarity, str]:
        """Return the given placement between pixels, and its source in words."""
        from rectmerge.results.alignment_json import AlignmentFile
        from rectmerge.results.saved_alignment import SavedAlignment

        if self.earlier is None:
            return parse_pixels(self.pixels or ""), "placed by hand"
        pixels = SavedAlignment.from_file(AlignmentFile.read(self.earlier)).pixels(self.candidate, a, b)
        if self.candidate is None:
            return pixels, "placed as an earlier merge did"
        return pixels, f"placed as candidate {self.candidate} of an earlier merge"


def parse_guess(text: str) -> tuple[float, float, float]:
    """Parse ``x,y,yaw``.

    Examples
    --------
    >>> parse_guess("1.5,-2,0.1")
    (1.5, -2.0, 0.1)
    """
    x, y, yaw = _numbers(text, (3,), "x,y,yaw: metres and radians in A's map frame")
    return x, y, yaw


def parse_point(text: str) -> tuple[float, float]:
    """Parse ``x,y``.

    Examples
    --------
    >>> parse_point("1.5,-2")
    (1.5, -2.0)
    """
    x, y = _numbers(text, (2,), "x,y: a point of map B, in its map frame")
    return x, y


def parse_pixels(text: str) -> Similarity:
    """Parse ``a,b,tx,ty``, or the matrix ``a,-b,tx,b,a,ty``, from B's pixels to A's.

    Examples
    --------
    >>> parse_pixels("0,1,5,6") == parse_pixels("0,-1,5,1,0,6")
    True
    """
    from rectmerge.similarity import Similarity

    numbers = _numbers(text, (4, 6), "a,b,tx,ty, or the six numbers of a matrix a,-b,tx,b,a,ty")
    if len(numbers) == 4:
        a, b, tx, ty = numbers
        numbers = [a, -b, tx, b, a, ty]
    return Similarity.from_matrix([numbers[:3], numbers[3:]])


def _numbers(text: str, counts: Sequence[int], form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise InputError(f"{text!r} is not {form}")
    return numbers
