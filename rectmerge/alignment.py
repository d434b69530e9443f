"""Alignment of two maps: verdict, reason and candidates with their evidence; and the interface of a method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import Agreement, measure_agreement
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity

Verdict = Literal["accepted", "ambiguous", "rejected"]
ScaleSource = Literal["resolution", "search", "given"]
SCHEMA = "rectmerge.alignment/1"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate:
    """Placement of B on A, with its evidence.

    Parameters
    ----------
    b_to_a
        From B's map frame to A's.
    pixels
        The same between the pixel centres of the two images.
    confidence
        Probability that this placement is right, 0..1.
    overlap, conflict
        As in `rectmerge.analysis.overlap.Agreement`.
    covariance
        Shape (4, 4) over (angle, ln scale, tx, ty) about the centroid of the overlap, in A's map frame; None where
        the method has none.
    evidence
        Measurements of the method for this placement, by name.
    """

    b_to_a: Similarity
    pixels: Similarity
    confidence: float
    overlap: float
    conflict: float
    covariance: NDArray[np.float64] | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def from_pixels(
        cls,
        pixels: Similarity,
        a: OccupancyGrid,
        b: OccupancyGrid,
        *,
        confidence: float,
        agreement: Agreement | None = None,
        covariance: NDArray[np.float64] | None = None,
        evidence: Mapping[str, float] | None = None,
    ) -> Candidate:
        """Make a candidate from its pixel similarity; the agreement of the maps is measured unless given."""
        agreement = agreement or measure_agreement(a, b, pixels)
        return cls(
            b_to_a=pixels_to_map_frame(pixels, a, b),
            pixels=pixels,
            confidence=confidence,
            overlap=agreement.overlap,
            conflict=agreement.conflict,
            covariance=covariance,
            evidence=evidence or {},
        )

    def as_dict(self, unit: str) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "b_to_a": _similarity_dict(self.b_to_a, unit),
            "pixels": self.pixels.matrix.tolist(),
            "confidence": self.confidence,
            "overlap": self.overlap,
            "conflict": self.conflict,
            "covariance": None if self.covariance is None else self.covariance.tolist(),
            "evidence": dict(self.evidence),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleReport:
    """Pixel scale (cells of A per cell of B): found, expected from the resolutions, and the source of its bounds."""

    found: float | None = None
    expected: float | None = None
    source: ScaleSource = "search"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alignment:
    """Alignment of map B with map A; truthy only when it is accepted.

    Parameters
    ----------
    verdict
        "accepted", "ambiguous" (several placements explain the maps about as well) or "rejected".
    reason
        One line a user can act on.
    method
        The name of the method that answered.
    candidates
        Best first, whatever the verdict; empty where nothing could be placed at all.
    confidence
        Probability that the best candidate is right, 0..1.
    unit
        Unit of A's map frame, "m" or "cells".
    scale
        The pixel scale.
    method_verdict
        The method's own verdict, where `verdict` is another's: the judge's, or that of the declared resolutions (see
        `rectmerge.aligning.align`); None where it is the method's.
    checked
        The verdict of the judge to whom the answer was put (`rectmerge.judging.confirm`); None where it was not.
    quality
        The accuracy of each map as the method measured it, by map ("a", "b") and by name.
    trace
        Steps of the method, for reports: plain data.
    seconds
        Wall time.
    """

    verdict: Verdict
    reason: str
    method: str
    candidates: tuple[Candidate, ...] = ()
    confidence: float = 0.0
    unit: str = "cells"
    scale: ScaleReport = field(default_factory=ScaleReport)
    method_verdict: Verdict | None = None
    checked: Verdict | None = None
    quality: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    trace: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 0.0

    def __bool__(self) -> bool:
        return self.verdict == "accepted"

    @property
    def b_to_a(self) -> Similarity | None:
        """The accepted similarity from B's map frame to A's; None unless accepted."""
        return self.candidates[0].b_to_a if self else None

    @property
    def pixels(self) -> Similarity | None:
        """The accepted similarity between pixel centres; None unless accepted."""
        return self.candidates[0].pixels if self else None

    def headline(self, number: int = 1) -> str:
        """Return the verdict and the confidence in a candidate, 1 being the best, as the title of a picture."""
        candidate = "" if self else f": candidate {number} of {len(self.candidates)}"
        return f"{self.verdict}{candidate}, confidence {self.candidates[number - 1].confidence:.2f}"

    def with_candidate(self, number: int) -> Alignment:
        """Return the alignment with a candidate accepted by hand, 1 being the best; the others keep their order.

        Raises
        ------
        InputError
            If there is no candidate of this number.
        """
        if not 1 <= number <= len(self.candidates):
            raise InputError(f"there is no candidate {number}: {self.verdict} with {len(self.candidates)} candidates")
        if self and number == 1:
            return self
        accepted = self.candidates[number - 1]
        others = tuple(candidate for candidate in self.candidates if candidate is not accepted)
        return replace(
            self,
            verdict="accepted",
            reason=f"candidate {number}, chosen by hand; unaided the verdict is: {self.verdict}, {self.reason}",
            candidates=(accepted, *others),
            confidence=accepted.confidence,
            scale=replace(self.scale, found=accepted.pixels.scale),
        )

    def with_placement(self, pixels: Similarity, a: OccupancyGrid, b: OccupancyGrid, *, source: str) -> Alignment:
        """Return the alignment with its best candidate replaced by a placement that is accepted as it is given.

        Parameters
        ----------
        pixels
            The placement between the pixels of the two images.
        a, b
            The two maps.
        source
            Origin of the placement, the start of the reason; the verdict on the walls follows it.
        """
        candidate = Candidate.from_pixels(pixels, a, b, confidence=self.confidence)
        return replace(
            self,
            verdict="accepted",
            reason=f"{source}; the walls say: {self.verdict}, {self.reason}",
            candidates=(candidate, *self.candidates[1:]),
            scale=replace(self.scale, found=pixels.scale, source="given"),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the content of ``alignment.json``."""
        best = self.candidates[0] if self.candidates else None
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "method_verdict": self.method_verdict or self.verdict,
            "checked": self.checked,
            "reason": self.reason,
            "confidence": self.confidence,
            "method": self.method,
            "b_to_a": None if self.b_to_a is None else _similarity_dict(self.b_to_a, self.unit),
            "pixels": None if self.pixels is None else self.pixels.matrix.tolist(),
            "scale": {"found": self.scale.found, "expected": self.scale.expected, "from": self.scale.source},
            "overlap": best.overlap if best else None,
            "conflict": best.conflict if best else None,
            "quality": {name: dict(values) for name, values in self.quality.items()},
            "candidates": [candidate.as_dict(self.unit) for candidate in self.candidates],
            "seconds": self.seconds,
            **({"trace": dict(self.trace)} if self.trace else {}),
        }


def right_resolutions(a: float, b: float, ratio: float) -> str:
    """Name the right value of either resolution where maps fit at `ratio` times the scale that both give.

    Examples
    --------
    >>> right_resolutions(0.05, 0.6, 0.1)
    "B's would be 0.06 rather than 0.6, or A's 0.5 rather than 0.05"
    """
    return f"B's would be {b * ratio:.3g} rather than {b:.6g}, or A's {a / ratio:.3g} rather than {a:.6g}"


class Method(Protocol):
    """Method to align two maps: a frozen dataclass with a name, its parameters as fields, and `align`."""

    @property
    def name(self) -> str:
        """The name people type."""

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""


class Certificate(Protocol):
    """Proof, or counterexample, that no other placement scores nearly as well as an accepted one; true if a proof."""

    @property
    def counterexample(self) -> Similarity | None:
        """Another placement that scores nearly as well, between the pixel centres."""

    @property
    def seconds(self) -> float:
        """Wall time."""

    def __bool__(self) -> bool: ...

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""

    def __str__(self) -> str:
        """Return a line for the terminal."""


@runtime_checkable
class Certifies(Method, Protocol):
    """Method that can certify its accepted placements: an optional capability."""

    def certify(
        self, a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity, *, scale: tuple[float, float], seconds: float
    ) -> Certificate:
        """Prove within some seconds that no placement elsewhere scores nearly as well, or find one."""


def _similarity_dict(similarity: Similarity, unit: str) -> dict[str, Any]:
    return {
        "scale": similarity.scale,
        "angle_rad": similarity.angle,
        "translation": [similarity.tx, similarity.ty],
        "unit": unit,
    }
