"""Alignment of an earlier merge, read from its ``alignment.json`` to be used as a transform."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rectmerge.alignment import Verdict
from rectmerge.analysis.shared_area import SharedArea
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.results.alignment_json import AlignmentFile
from rectmerge.similarity import Similarity
from rectmerge.transfer.transform import FRAMES, Transform


@dataclass(frozen=True, slots=True)
class SavedAlignment:
    """Verdict and candidates of an earlier merge.

    Parameters
    ----------
    file
        The file that it was read from.
    verdict, reason
        As in `rectmerge.alignment.Alignment`.
    candidates
        Best first.
    frames
        Names of A's and B's map frame; None where the maps have none.
    """

    file: Path
    verdict: Verdict
    reason: str
    candidates: tuple[Transform, ...]
    frames: tuple[str | None, str | None] = (None, None)

    @classmethod
    def from_file(cls, file: AlignmentFile) -> SavedAlignment:
        """Take the alignment from the record of a merge.

        Raises
        ------
        InputError
            If it lacks a number of a candidate.
        """
        with file.explain_errors():
            resolutions = _resolutions(file)
            candidates = tuple(_transform(entry, resolutions) for entry in file.record["candidates"])
            a, b = (name if isinstance(name := file.input_field(key, "frame"), str) else None for key in "ab")
            return cls(file.path, file.verdict, file.reason, candidates, (a, b))

    def frame_names(self, parent: str | None, child: str | None) -> tuple[str, str]:
        """Return the names of the frames: as given, else the maps' own where they differ, else `FRAMES`."""
        a, b = self.frames
        names = (a, b) if a and b and a != b else FRAMES
        return (names[0] if parent is None else parent), (names[1] if child is None else child)

    def candidate(self, number: int) -> Transform:
        """Return a candidate, 1 being the best.

        Raises
        ------
        InputError
            If there is no candidate of this number.
        """
        if not 1 <= number <= len(self.candidates):
            raise InputError(f"there is no candidate {number}; the answer holds {len(self.candidates)}")
        return self.candidates[number - 1]

    def pixels(self, number: int | None, a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
        """Return a candidate between the pixels of maps in the same frames; of an accepted alignment None is the best.

        Raises
        ------
        InputError
            If there is no such candidate, none is named and none is accepted, or map A has another unit.
        """
        if number is None and self.verdict != "accepted":
            raise InputError(
                f"{self.file}: {self.verdict}; name one of its {len(self.candidates)} candidates by --candidate"
            )
        candidate = self.candidate(number or 1)
        if candidate.unit != a.unit:
            raise InputError(
                f"{self.file}: places map B in {candidate.unit}, but map A is in {a.unit}; give --resolution-a"
            )
        return map_frame_to_pixels(candidate.b_to_a, a, b)


def _resolutions(file: AlignmentFile) -> tuple[float, float] | None:
    a, b = (file.input_field(name, "metres_per_cell") for name in "ab")
    are_known = isinstance(a, int | float) and isinstance(b, int | float) and a > 0 and b > 0
    return (float(a), float(b)) if are_known else None


def _transform(entry: Mapping[str, Any], resolutions: tuple[float, float] | None) -> Transform:
    similarity, shared = entry["b_to_a"], entry["shared"]
    x, y = shared["centre"]
    b_to_a = Similarity(similarity["scale"], similarity["angle_rad"], *similarity["translation"])
    area = SharedArea((x, y), shared["radius"], shared.get("unit", similarity["unit"]))
    return Transform(b_to_a, area, similarity["unit"], resolutions)
