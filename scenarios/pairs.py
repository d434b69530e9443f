"""A pair of maps with its truth, and how one is made from a mission log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapPair:
    """Two maps and what is known of how they relate.

    Parameters
    ----------
    pair_id
        Unique in its suite or data set.
    a, b
        The maps as a method sees them: a hidden resolution is None.
    related
        Whether the maps show the same place at all.
    pixels
        The true pixel similarity from B to A: the least-squares fit to the control points. None when unrelated.
    control_points
        Shape (N, 4), rows (ua, va, ub, vb): the same surface points in the pixels of both maps. None when unrelated.
    residual_px
        RMSE of `pixels` on the control points, in A's pixels. None when unrelated.
    suite, place
        Where the pair belongs; `place` is the cluster for statistics.
    overlap
        The true overlap as in DESIGN's scoring, None where it has to be measured.
    info
        Everything else a row may carry: family, variant, seed, noise, resolution_a, resolution_b, pose_source, ...
    """

    pair_id: str
    a: OccupancyGrid
    b: OccupancyGrid
    related: bool
    pixels: Similarity | None
    control_points: NDArray[np.float64] | None
    residual_px: float | None
    suite: str
    place: str
    overlap: float | None = None
    info: Mapping[str, Any] = field(default_factory=dict)


class PairSource(Protocol):
    """Work that yields pairs: a mission to run, or a row of a data set to read. Picklable and cheap until asked."""

    @property
    def source_id(self) -> str:
        """A name for progress and for errors."""

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """The ids of the pairs it yields, known before they are made."""

    def pairs(self) -> Iterator[MapPair]:
        """Make or read the pairs."""
