"""Prepared map: the features, directions and frames of one map, before the other one is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.quality import MapQuality, measure_quality
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.derived import derive
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.detailed_map import DetailedMap
from rectmerge.robust.directions import direction_energies, dominant_angles
from rectmerge.robust.features import Features, Frame, extract_features, rectangles_in_frame
from rectmerge.robust.params import Params
from rectmerge.robust.reasons import MapFacts


@dataclass(frozen=True, eq=False)
class PreparedMap:
    """Map with the directions in which its walls pile up, and the rectangles in the frames of the strong ones."""

    grid: OccupancyGrid
    cells: MapCells
    quality: MapQuality
    params: Params
    features: Features | None
    angles: Sequence[tuple[float, float]] = ()
    frames: Sequence[Frame] = ()

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, params: Params) -> PreparedMap:
        """Prepare a map, once within `derived_kept`; it has no features where no wall borders on free space."""

        def prepare() -> PreparedMap:
            cells = MapCells.from_grid(grid, max_speck_cells=params.prepare.max_speck_cells)
            return cls._from_cells(grid, cells, measure_quality(grid), params)

        return derive(grid, (cls, params), prepare)

    @cached_property
    def mirrored(self) -> PreparedMap:
        """The mirror image of the map, prepared."""
        return self._from_cells(self.grid, self.cells.mirrored(), self.quality, self.params)

    @classmethod
    def _from_cells(cls, grid: OccupancyGrid, cells: MapCells, quality: MapQuality, params: Params) -> PreparedMap:
        features = extract_features(cells, params.prepare)
        if features is None:
            return cls(grid, cells, quality, params, None)
        angles = dominant_angles(features, params.prepare)
        strong = [angle for angle, contrast in angles[:2] if contrast >= params.prepare.strong_share * angles[0][1]]
        frames = [rectangles_in_frame(features, angle, params.prepare) for angle in strong]
        return cls(grid, cells, quality, params, features, angles, frames)

    @property
    def frame_angles(self) -> list[float]:
        """Angles of the strong frames, radians."""
        return [frame.angle for frame in self.frames]

    def all_frames(self) -> list[Frame]:
        """Return the frames of all directions in which walls pile up, the strong ones first."""
        weak = self.angles[len(self.frames) :]
        return [*self.frames, *self.frames_at([angle for angle, _ in weak])]

    def frames_at(self, angles: Sequence[float]) -> list[Frame]:
        """Return the frames at some angles, radians."""
        return [rectangles_in_frame(self.walled, angle, self.params.prepare) for angle in angles]

    @cached_property
    def detailed(self) -> DetailedMap:
        """Details of the map, which another map may contradict."""
        return DetailedMap.from_cells(self.cells, self.angles[0][0], self.walled.factor, self.params.detail)

    @cached_property
    def direction_energies(self) -> NDArray[np.float64]:
        """How much the walls pile up along each degree of a quarter turn, shape (90,)."""
        return direction_energies(self.walled, self.params.prepare)

    @property
    def contrast(self) -> float:
        """Contrast of the walls along the first frame."""
        return self.angles[0][1]

    @property
    def facts(self) -> MapFacts:
        """Facts that a reason may name."""
        free_cells = int(np.count_nonzero(self.walled.free))
        return MapFacts(free_cells=free_cells, roughness=self.cells.roughness())

    @property
    def thickness_cells(self) -> float:
        """Thickness of the walls."""
        return self.quality.wall_thickness_cells or 1.0

    @property
    def walled(self) -> Features:
        """Features of a map that has walls."""
        assert self.features is not None
        return self.features

    @property
    def rank(self) -> tuple[float, ...]:
        """Rank of the map, which does not depend on whether it is called A or B."""
        return len(self.walled.walls), self.grid.occupancy.size, float(self.walled.walls.sum())
