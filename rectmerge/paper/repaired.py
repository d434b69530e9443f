"""Paper's method with repairs, each a switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from rectmerge.analysis.dominant_angle import dominant_angle
from rectmerge.analysis.specks import remove_specks
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.iteration import ConditionError, Match, Turn, match_triangles, overlay
from rectmerge.paper.merging import Paper
from rectmerge.paper.orientation import smallest_turn
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap
from rectmerge.paper.triangles import shared_triangles
from rectmerge.paper.verification import WallImage, wall_agreement


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperRepaired(Paper):
    """The paper's method with each of its weak steps repaired; with all repairs off it is `Paper`.

    Parameters
    ----------
    max_speck_cells
        Greatest patch removed as a speck before Algorithm 2, in cells; 0 is off.
    orientation
        "projection": Lambda from the projection profiles of the walls; "ransac": Algorithm 3.
    side_share
        Tolerance of eq. 8 as a share of the longer side; 0 is off: `delta_cells` counts.
    swap_sides
        Also compare w with h in eq. 8, as partners at a quarter turn need.
    median_ratio
        The ratio of eq. 13 as the median over the widths and heights of all three rectangles, not one width.
    hypotheses
        Number of best triangles of eq. 12 that are placed and verified by their walls; 1 is off: the least J decides.
    wall_reach_cells
        Distance within which a wall agrees with another.
    max_walls
        Number of wall cells of a map that are compared, evenly spaced.
    max_rectangles, ratio_tolerance
        As in `Paper`, with more by default.

    Notes
    -----
    Source of all values: seeds 0-49 of the suite `headline`, noise 0 and 1; results/headline/README.md says what each
    repair earns on other seeds. All other fields are those of `Paper`. Measured stage by stage on the noisy pairs,
    Algorithm 2 lost most: with specks of up to 2 cells removed, 17 of 50 pairs had three common rectangles among the
    first twenty of each map, with specks of up to 8 cells 48 (without noise 45). The triangle of least J was the next.
    """

    name: ClassVar[str] = "paper-repaired"
    max_speck_cells: int = 8
    orientation: Literal["ransac", "projection"] = "projection"
    side_share: float = 0.3
    swap_sides: bool = True
    median_ratio: bool = True
    hypotheses: int = 50
    wall_reach_cells: float = 2.0
    max_walls: int = 1500
    max_rectangles: int = 30
    ratio_tolerance: float = 0.01

    def __post_init__(self) -> None:
        Paper.__post_init__(self)
        for field, least in {
            "max_speck_cells": 0,
            "side_share": 0,
            "hypotheses": 1,
            "wall_reach_cells": 0,
            "max_walls": 1,
        }.items():
            if not getattr(self, field) >= least:
                raise InputError(f"{field} must be >= {least}, got {getattr(self, field)}")
        if self.orientation not in ("ransac", "projection"):
            raise InputError(f'orientation must be "ransac" or "projection", got {self.orientation!r}')

    def prepared(self, grid: OccupancyGrid) -> OccupancyGrid:
        """Return a map without specks."""
        return remove_specks(grid, max_speck_cells=self.max_speck_cells)

    def turn(self, image: PlacedImage, name: str) -> Turn:
        """Return Lambda of a map."""
        if self.orientation == "ransac":
            return Paper.turn(self, image, name)
        self.rectangles(image, name)  # the paper's second condition
        return Turn(smallest_turn(-dominant_angle(OccupancyGrid(image.cells))))

    @property
    def tolerance(self) -> dict[str, Any]:
        """Arguments of `corresponding` (eq. 8)."""
        return {"delta_cells": self.delta_cells, "side_share": self.side_share, "swap_sides": self.swap_sides}

    def match(self, images: Sequence[PlacedImage], rmaps: Sequence[RMap]) -> Match:
        """Return the set of shared triangles, among the best ones, under which the walls agree most."""
        triangles = shared_triangles(
            rmaps[0].boxes,
            rmaps[1].boxes,
            **self.tolerance,
            min_area_cells=self.min_area_cells,
            max_rectangles=self.max_rectangles,
            weights=self.weights,
            max_comparisons=self.max_comparisons,
            keep=self.hypotheses,
        )
        if not triangles:
            raise ConditionError("no three rectangles of map A have three of map B with sides within the tolerance")
        matches = [match_triangles(rmaps[0], rmaps[1], best, median_ratio=self.median_ratio) for best in triangles]
        return matches[0] if len(matches) == 1 else self._verified(images, matches)

    def _verified(self, images: Sequence[PlacedImage], matches: Sequence[Match]) -> Match:
        """Return the match under which the walls of both images agree most."""
        upright = [PlacedImage.from_cells(image.cells) for image in images]
        a, b = (WallImage.from_cells(image.cells, max_walls=self.max_walls) for image in images)
        agreements = [
            wall_agreement(a, b, overlay(upright, match, match.ratio), reach_cells=self.wall_reach_cells)
            for match in matches
        ]
        return matches[int(np.argmax(agreements))]
