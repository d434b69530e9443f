"""Area that both maps show: its centre and its spread in the map frame of B."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rectmerge.analysis.overlap import cells_of
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

SAMPLED_CELLS = 20_000


@dataclass(frozen=True, slots=True)
class SharedArea:
    """Area that both maps show, in B's map frame.

    Parameters
    ----------
    centre
        Mean (x, y) of its cells, map units of B.
    radius
        RMS distance of its cells from the centre, map units of B.
    unit
        Unit of B's map frame, "m" or "cells".
    """

    centre: tuple[float, float]
    radius: float
    unit: str = "m"

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {"centre": list(self.centre), "radius": self.radius, "unit": self.unit}


def measure_shared_area(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> SharedArea:
    """Measure the area that is free in both maps.

    Parameters
    ----------
    a, b
        The two maps; B has free cells.
    pixels
        Placement of B on A, between the pixels of the images.

    Returns
    -------
    SharedArea
        All of B's free space where the maps share none.
    """
    cells = cells_of(b.free, SAMPLED_CELLS)[:, ::-1]
    at = np.rint(pixels.apply(cells)).astype(np.intp)
    inside = ((at >= 0) & (at < a.shape[::-1])).all(axis=1)
    u, v = at.clip(0, np.array(a.shape[::-1]) - 1).T
    shared = cells[inside & a.free[v, u]]
    points = b.pixel_to_map(shared if len(shared) else cells)
    centre = points.mean(axis=0)
    radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
    return SharedArea((float(centre[0]), float(centre[1])), radius, b.unit)
