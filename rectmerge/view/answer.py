"""What ``alignment.json`` tells, as the page shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rectmerge.alignment import Verdict
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.results.alignment_json import AnswerFile
from rectmerge.similarity import Similarity

SAME = 1e-6  # two placements that differ by no more, relatively, are one


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownCandidate:
    """A placement of B on A, between their pixels and between their map frames, with what speaks for it, 0..1.

    What was not measured is None.
    """

    pixels: Similarity
    b_to_a: Similarity
    confidence: float | None
    overlap: float | None
    conflict: float | None

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> ShownCandidate:
        """Take what is told of a candidate."""
        frame = told["b_to_a"]
        return cls(
            pixels=Similarity.from_matrix(told["pixels"]),
            b_to_a=Similarity(frame["scale"], frame["angle_rad"], *frame["translation"]),
            **{name: _share(told[name]) for name in ("confidence", "overlap", "conflict")},
        )

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for the page; the matrix is six numbers, row by row."""
        shares = {"confidence": self.confidence, "overlap": self.overlap, "conflict": self.conflict}
        return {"pixels": self.pixels.matrix.ravel().tolist(), **shares}


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownAnswer:
    """The verdict, its reason, the method that gave it, and the candidates, best first."""

    verdict: Verdict
    reason: str
    method: str
    confidence: float | None
    candidates: tuple[ShownCandidate, ...]

    @classmethod
    def of(cls, file: AnswerFile) -> ShownAnswer:
        """Take what an answer tells.

        Raises
        ------
        InputError
            If it lacks what is to be shown.
        """
        with file.refusing():
            return cls(
                verdict=file.verdict,
                reason=file.reason,
                method=str(file.told["method"]),
                confidence=_share(file.told["confidence"]),
                candidates=tuple(map(ShownCandidate.of, file.told["candidates"])),
            )

    def fits(self, a: OccupancyGrid, b: OccupancyGrid) -> bool:
        """Whether the maps can be those of the merge: by their sizes, resolutions and origins."""
        return all(
            np.allclose(pixels_to_map_frame(one.pixels, a, b).matrix, one.b_to_a.matrix, rtol=SAME, atol=SAME)
            for one in self.candidates
        )


def _share(told: float | None) -> float | None:
    return None if told is None else float(told)
