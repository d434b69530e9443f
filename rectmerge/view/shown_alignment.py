"""Alignment of an earlier merge, read from its ``alignment.json`` to be shown on the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rectmerge.alignment import Verdict
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.results.alignment_json import AlignmentFile
from rectmerge.similarity import Similarity

TOLERANCE = 1e-6  # relative and absolute, between the numbers of equal placements


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownCandidate:
    """Placement of B on A, between their pixels and between their map frames, with its evidence.

    Confidence, overlap and conflict lie in 0..1 and are None where the method did not measure them.
    """

    pixels: Similarity
    b_to_a: Similarity
    confidence: float | None
    overlap: float | None
    conflict: float | None

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> ShownCandidate:
        """Take a candidate from the record of a merge."""
        frame = record["b_to_a"]
        return cls(
            pixels=Similarity.from_matrix(record["pixels"]),
            b_to_a=Similarity(frame["scale"], frame["angle_rad"], *frame["translation"]),
            **{name: _optional_float(record[name]) for name in ("confidence", "overlap", "conflict")},
        )

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for the page; the matrix is six numbers, row by row."""
        evidence = {"confidence": self.confidence, "overlap": self.overlap, "conflict": self.conflict}
        return {"pixels": self.pixels.matrix.ravel().tolist(), **evidence}


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownAlignment:
    """Verdict, reason, method and candidates of an earlier merge, the best candidate first."""

    verdict: Verdict
    reason: str
    method: str
    confidence: float | None
    candidates: tuple[ShownCandidate, ...]

    @classmethod
    def from_file(cls, file: AlignmentFile) -> ShownAlignment:
        """Take the alignment from the record of a merge.

        Raises
        ------
        InputError
            If it lacks a key that the page shows.
        """
        with file.explain_errors():
            return cls(
                verdict=file.verdict,
                reason=file.reason,
                method=str(file.record["method"]),
                confidence=_optional_float(file.record["confidence"]),
                candidates=tuple(map(ShownCandidate.from_record, file.record["candidates"])),
            )

    def fits(self, a: OccupancyGrid, b: OccupancyGrid) -> bool:
        """Return whether the maps can be those of the merge, by their sizes, resolutions and origins."""
        return all(
            np.allclose(
                pixels_to_map_frame(candidate.pixels, a, b).matrix,
                candidate.b_to_a.matrix,
                rtol=TOLERANCE,
                atol=TOLERANCE,
            )
            for candidate in self.candidates
        )


def _optional_float(value: float | None) -> float | None:
    return None if value is None else float(value)
