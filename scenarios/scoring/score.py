"""Scoring of an answer against a pair's truth: errors over control points, a grade, and the outcome of a row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal, TypedDict, cast

import numpy as np
from numpy.typing import ArrayLike

from rectmerge.alignment import Verdict
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse, known_extent

Outcome = Literal[
    "right-accepted",
    "wrong-accepted",  # of an unrelated pair: a false merge
    "ambiguous-with-truth",
    "ambiguous-without-truth",
    "rejected",
    "error",
    "timeout",
    "out-of-memory",
]
Stratum = Literal["required", "optional", "unrelated"]
Grade = Literal["fine", "right", "coarse", "off"]

FAILURES: tuple[Outcome, ...] = ("error", "timeout", "out-of-memory")
RIGHT: tuple[Grade, ...] = ("fine", "right")
UNRELATED_BELOW = 0.05  # overlap
REQUIRED_FROM = 0.15
CANDIDATES_HEARD = 5  # an ambiguous answer may hold the truth among its first five


class ErrorValues(TypedDict):
    """Errors as plain data for JSON."""

    e_px: float
    e_over_l: float
    e_m: float | None
    rotation_deg: float
    scale_pct: float
    reflected: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Errors of an answer against the truth.

    Parameters
    ----------
    e_px
        RMSE over the control points of ``|T p_b - p_a|``, in cells of A.
    e_over_l
        The same over L, the diagonal of the bounding box of A's known cells.
    e_m
        The same in metres; None where A's resolution is not known to the benchmark.
    rotation_deg, scale_pct
        Absolute differences from the true similarity, degrees (0..180) and percent.
    reflected
        Whether the answer mirrors the map: such an answer is never right.
    """

    e_px: float
    e_over_l: float
    e_m: float | None
    rotation_deg: float
    scale_pct: float
    reflected: bool

    def as_dict(self) -> ErrorValues:
        """Return plain data for JSON."""
        return cast(ErrorValues, asdict(self))


def measure_errors(found: Similarity | ArrayLike, pair: MapPair) -> Errors:
    """Measure an answer against the truth of a related pair.

    Parameters
    ----------
    found
        The answer: a similarity from B's pixels to A's, or any 2x3 matrix, which may mirror.
    pair
        A pair with its truth.

    Raises
    ------
    InputError
        If the pair has no truth, or the matrix is not 2x3 and finite.

    Examples
    --------
    >>> from rectmerge.grid import OccupancyGrid
    >>> a = OccupancyGrid(np.zeros((30, 40), np.int8))
    >>> points = np.array([[0.0, 0.0, 0.0, 0.0], [10.0, 0.0, 5.0, 0.0]])
    >>> pair = MapPair(pair_id="p", a=a, b=a, related=True, pixels=Similarity(2.0), control_points=points,
    ...                residual_px=0.0, suite="s", place="h")
    >>> shifted = measure_errors(Similarity(2.0, 0.0, 3.0, 4.0), pair)
    >>> shifted.e_px, shifted.e_over_l, shifted.rotation_deg
    (5.0, 0.1, 0.0)
    """
    if pair.pixels is None or pair.control_points is None:
        raise InputError(f"pair {pair.pair_id} has no truth to measure against")
    m = found.matrix if isinstance(found, Similarity) else np.asarray(found, dtype=np.float64)
    if m.shape != (2, 3) or not np.isfinite(m).all():
        raise InputError(f"an answer is a finite 2x3 matrix, got {m.tolist()}")
    det = float(m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0])
    turn = math.atan2(m[1, 0] - m[0, 1], m[0, 0] + m[1, 1]) - pair.pixels.angle
    e_px = control_point_rmse(m, pair.control_points)
    resolution = pair.a.resolution or pair.info.get("resolution_a")
    return Errors(
        e_px=e_px,
        e_over_l=e_px / known_extent(pair.a),
        e_m=e_px * float(resolution) if resolution else None,
        rotation_deg=abs(math.degrees(math.remainder(turn, math.tau))),
        scale_pct=100.0 * abs(math.sqrt(abs(det)) / pair.pixels.scale - 1.0),
        reflected=det <= 0,
    )


def grade(errors: Errors, residual_over_l: float) -> Grade:
    """Grade an answer: "fine" is also right, "right" is also coarse, "off" is none of them.

    Right is e < max(1 % L, 2 x residual), rotation < 5 degrees, scale < 5 %, no reflection.

    Parameters
    ----------
    errors
        As measured.
    residual_over_l
        The truth's own residual on the control points over L.
    """
    if errors.reflected:
        return "off"
    e, turn, scale = errors.e_over_l, errors.rotation_deg, errors.scale_pct
    if e < max(0.01, 2.0 * residual_over_l) and turn < 5.0 and scale < 5.0:
        return "fine" if e < max(0.0025, 1.2 * residual_over_l) else "right"
    return "coarse" if e < 0.05 and turn < 10.0 and scale < 10.0 else "off"


def stratum_of(related: bool, overlap: float | None) -> Stratum:
    """Return the stratum of a pair: "required" to merge, "optional", or "unrelated" and to be refused.

    A related pair without a known overlap (annotated by hand) is required.
    """
    if not related or (overlap is not None and overlap < UNRELATED_BELOW):
        return "unrelated"
    return "optional" if overlap is not None and overlap < REQUIRED_FROM else "required"


def outcome_of(verdict: Verdict, grades: Sequence[Grade], stratum: Stratum) -> Outcome:
    """Name the outcome of an answer that was given.

    Parameters
    ----------
    verdict
        What the method said.
    grades
        Of its candidates, best first; empty for a pair without truth.
    stratum
        Of the pair. No answer to an unrelated pair is right: to accept it is a false merge.
    """
    if verdict == "rejected":
        return "rejected"
    heard = grades[: 1 if verdict == "accepted" else CANDIDATES_HEARD]
    right = stratum != "unrelated" and any(g in RIGHT for g in heard)
    if verdict == "accepted":
        return "right-accepted" if right else "wrong-accepted"
    return "ambiguous-with-truth" if right else "ambiguous-without-truth"
