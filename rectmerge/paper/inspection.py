"""Inspection of one map by the paper's first steps: rectangles, their neighbours, edges and orientation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.descriptors import MapDescriptors, describe_map
from rectmerge.analysis.quality import MapQuality, measure_quality
from rectmerge.drawing.maps import Picture, draw_parallels, draw_rectangles, draw_series, side_by_side
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.paper.edges import largest_neighbours
from rectmerge.paper.orientation import Orientation, orthogonal_orientation
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap, Side, rmap

MARGIN_CELLS = 5
LISTED_RECTANGLES = 20  # rectangles that are numbered and listed, as in figure 3
LEGEND_LABELS = 8  # of a series: laser maps have series of 50 labels, and such a line is wider than the picture


@dataclass(frozen=True, slots=True, eq=False)
class Inspection:
    """Rectangles, orientation, accuracy and descriptors of a map.

    Parameters
    ----------
    grid
        The map.
    r_map
        Its R-map (Algorithm 2).
    series
        For each direction the labels of the largest neighbours from rectangle 1 outwards (table I).
    orientation
        The orientation by Algorithm 3, None where no edges are parallel.
    quality
        The map's own accuracy.
    descriptors
        Its specks, pinholes, slivers, frontiers and gaps.
    """

    grid: OccupancyGrid
    r_map: RMap
    series: dict[Side, list[int]]
    orientation: Orientation | None
    quality: MapQuality
    descriptors: MapDescriptors

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; rectangles are (x, y, w, h) in cells, labels count from 1."""
        height, width = self.grid.shape
        size = self.grid.cell_size
        cells = {name: int(getattr(self.grid, name).sum()) for name in ("free", "occupied", "unknown")}
        turn = None if self.orientation is None else math.degrees(self.orientation.turn)
        return {
            "width": width,
            "height": height,
            "extent": [width * size, height * size],
            "unit": self.grid.unit,
            "resolution": self.grid.resolution,
            "origin": list(self.grid.origin),
            "cells": cells,
            "rectangles": {"count": len(self.r_map), "largest": self.r_map.boxes[:LISTED_RECTANGLES].tolist()},
            "largest_neighbours": {str(side): labels for side, labels in self.series.items()},
            "upright_after_deg": turn,
            "quality": self.quality.as_dict(),
            "descriptors": self.descriptors.as_dict(),
        }

    def __str__(self) -> str:
        data = self.as_dict()
        resolution = "not known" if self.grid.resolution is None else f"{self.grid.resolution:g} m per cell"
        turn = data["upright_after_deg"]
        upright = "no parallel edges found" if turn is None else f"upright after a turn of {turn:+.2f} deg"
        quality = self.quality.as_dict()
        thickness, straight = quality.get("wall_thickness_cells"), quality.get("straightness")
        walls = "no walls" if straight is None else f"{thickness:.1f} cells thick, {straight:.0%} straight"
        details = self.descriptors
        near_walls = details.specks_near_walls
        places = "" if near_walls is None else f", {near_walls:.0%} of them near walls"
        largest = ", ".join(f"{w} x {h}" for _, _, w, h in data["rectangles"]["largest"][:3])
        return "\n".join(
            [
                f"  size         {data['width']} x {data['height']} cells, resolution {resolution}",
                f"  free space   {_area(data['cells']['free'], self.grid.resolution)}",
                f"  rectangles   {len(self.r_map):,}, the largest {largest} cells",
                f"  orientation  {upright}",
                f"  walls        {walls}",
                f"  speckle      {quality['speckle']:.2%} of the known cells stand alone",
                f"  specks       {details.specks or 0.0:.2f} per 100 free cells{places}",
                f"  floor        {details.pinholes or 0.0:.1f} % pinholes, {details.slivers or 0.0:.1f} % slivers,"
                f" {details.frontier_share or 0.0:.0%} of its border open",
            ]
        )

    def draw(self) -> Picture:
        """Draw figures 3 to 6 of the paper for this map, RGB."""
        boxes = self.r_map.rectangles
        chains = {f"{side}: {_first_few(labels)}": labels for side, labels in self.series.items()}
        panels = {
            f"rectangles: {len(boxes)}, the first {min(LISTED_RECTANGLES, len(boxes))} numbered": draw_rectangles(
                self.grid, boxes
            ),
            "largest neighbours of rectangle 1": draw_series(
                self.grid,
                boxes,
                {name: [0, *(label - 1 for label in labels)] for name, labels in chains.items()},
                numbered=LEGEND_LABELS + 1,  # and rectangle 1 itself
            ),
        }
        if self.orientation is not None:
            lines = self.orientation.line, self.orientation.facing_line
            pair = tuple(np.array(line, np.float64) - 0.5 for line in lines)  # from corners of cells to pixel centres
            panels["parallel edges"] = draw_parallels(self.grid, [(pair[0], pair[1])], self.orientation.turn)
            upright = _cropped(PlacedImage.from_cells(self.grid.occupancy).turned(self.orientation.turn).cells)
            turned = rmap(upright.free).rectangles
            panels[f"turned upright: {len(turned)} rectangles"] = draw_rectangles(upright, turned)
        return side_by_side(list(panels.values()), list(panels))


def inspect_map(grid: OccupancyGrid) -> Inspection:
    """Find the rectangles, neighbours, edges and orientation of a map with free cells, and measure its accuracy.

    Raises
    ------
    InputError
        If the map has no free cell.
    """
    r_map = rmap(grid.free)
    series, orientation = largest_neighbours(r_map, 1), orthogonal_orientation(r_map)
    return Inspection(grid, r_map, series, orientation, measure_quality(grid), describe_map(grid))


def _first_few(labels: Sequence[int]) -> str:
    shown = ", ".join(map(str, labels[:LEGEND_LABELS])) or "none"
    return shown if len(labels) <= LEGEND_LABELS else f"{shown}, ... ({len(labels)} in all)"


def _area(cells: int, resolution: float | None) -> str:
    """Return an area in whole cells, or in square metres to about four digits, never as a power of ten."""
    if resolution is None:
        return f"{cells:,} cells"
    area = cells * resolution**2
    return f"{area:,.0f} square metres" if area >= 1000 else f"{area:.4g} square metres"


def _cropped(cells: NDArray[np.int8]) -> OccupancyGrid:
    """Crop a turned image to its known cells with a margin, as most of its canvas is empty."""
    framed = np.pad(cells, MARGIN_CELLS, constant_values=UNKNOWN)
    rows, cols = (np.flatnonzero((framed != UNKNOWN).any(axis=axis)) for axis in (1, 0))
    (top, bottom), (left, right) = ((line[0] - MARGIN_CELLS, line[-1] + MARGIN_CELLS + 1) for line in (rows, cols))
    return OccupancyGrid(framed[top:bottom, left:right])
