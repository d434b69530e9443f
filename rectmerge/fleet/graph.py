"""Graph of aligned maps: what belongs together, where each map lies, and a reason for each that is left out."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.similarity import Similarity

Status = Literal["used", "promoted", "thrown out", "undecided", "unrelated", "not asked"]
SCHEMA = "rectmerge.fleet/1"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placement:
    """Placement of a map in the frame of its component's reference.

    Parameters
    ----------
    reference
        Name of the map whose frame it is: of the component's maps the one given first.
    to_reference
        From the map's frame to the reference's.
    pixels
        The same between the pixel centres of the two images.
    confidence
        Probability that the map lies right relative to the reference, 0..1; see `rectmerge.fleet.confidence`.
    covariance
        Shape (4, 4) over (angle, ln scale, tx, ty) about the centroid of the map's free space, in the reference's map
        frame; None for the reference.
    unit
        Unit of the reference's map frame, "m" or "cells".
    rests_on
        Pairs of this map that agree with the placement.
    """

    reference: str
    to_reference: Similarity
    pixels: Similarity
    confidence: float
    covariance: NDArray[np.float64] | None
    unit: str
    rests_on: tuple[tuple[str, str], ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        place = self.to_reference
        return {
            "reference": self.reference,
            "to_reference": {
                "scale": place.scale,
                "angle_rad": place.angle,
                "translation": [place.tx, place.ty],
                "unit": self.unit,
            },
            "pixels": self.pixels.matrix.tolist(),
            "confidence": self.confidence,
            "covariance": None if self.covariance is None else self.covariance.tolist(),
            "rests_on": [list(pair) for pair in self.rests_on],
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairAnswer:
    """Answer of a pair, and its part in the graph.

    Parameters
    ----------
    status
        "used": accepted, and in agreement with the graph. "promoted": not accepted by itself, but one of its
        candidates agrees with the graph. "thrown out": accepted, and contradicted by the others. "undecided": ambiguous
        or accepted, and nothing settles it. "unrelated": nothing found. "not asked".
    reason
        One line.
    alignment
        Answer of the method; None where it was not asked.
    candidate
        Number of the candidate that agrees with the graph, 1 being the best; None where none does.
    """

    status: Status
    reason: str
    alignment: Alignment | None = None
    candidate: int | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "status": self.status,
            "reason": self.reason,
            "candidate": self.candidate,
            "alignment": None if self.alignment is None else self.alignment.as_dict(),
        }


NOT_ASKED = PairAnswer(status="not asked", reason="other pairs looked more alike, and no join needed this one")


class Pairs(Mapping[tuple[str, str], PairAnswer]):
    """Answers of all pairs of some maps, by (A, B) in the order given; only those asked take memory."""

    def __init__(self, names: Sequence[str], asked: Mapping[tuple[str, str], PairAnswer]) -> None:
        self.asked = asked
        self._place = {name: index for index, name in enumerate(names)}

    def __getitem__(self, pair: tuple[str, str]) -> PairAnswer:
        a, b = pair
        if not self._place[a] < self._place[b]:
            raise KeyError(pair)
        return self.asked.get((a, b), NOT_ASKED)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return itertools.combinations(self._place, 2)

    def __len__(self) -> int:
        return len(self._place) * (len(self._place) - 1) // 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AlignmentGraph:
    """Alignment of any number of maps; truthy only when one component holds all.

    Parameters
    ----------
    names
        Names of the maps, in the order given.
    components
        Names of the maps that belong together, largest component first; the first name of each is its reference.
        Maps that belong to no other are in `left_out`.
    placements
        Placement of each map of a component, by name.
    pairs
        Answers of all pairs, by the names of (A, B), A being given first.
    left_out
        Reason for each map in no component, by name: one line a user can act on.
    bridges
        Pairs without which a component would fall apart: that joins rests on one pair alone.
    method
        Name of the method that answered.
    digests
        Fingerprints of the maps' cells, by name, by which a later call knows which answers still hold.
    changes
        Placement of an earlier graph that did not stay, by name: a line each.
    seconds
        Wall time.
    """

    names: tuple[str, ...]
    components: tuple[tuple[str, ...], ...]
    placements: Mapping[str, Placement]
    pairs: Pairs
    left_out: Mapping[str, str]
    bridges: tuple[tuple[str, str], ...]
    method: str
    digests: Mapping[str, str]
    changes: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0

    def __bool__(self) -> bool:
        return len(self.components) == 1 and not self.left_out

    @property
    def asked(self) -> int:
        """Number of pairs whose answers are known."""
        return len(self.pairs.asked)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the content of ``fleet.json``."""
        return {
            "schema": SCHEMA,
            "all_in_one": bool(self),
            "maps": list(self.names),
            "components": [list(names) for names in self.components],
            "placements": {name: placement.as_dict() for name, placement in self.placements.items()},
            "left_out": dict(self.left_out),
            "bridges": [list(pair) for pair in self.bridges],
            "pairs": [{"a": a, "b": b} | answer.as_dict() for (a, b), answer in self.pairs.asked.items()],
            "method": self.method,
            "digests": dict(self.digests),
            "changes": dict(self.changes),
            "seconds": self.seconds,
        }
