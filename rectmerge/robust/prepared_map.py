"""A map with all that the method reads off it before it looks at the other one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rectmerge.analysis.quality import MapQuality
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.features import Features, Frame, dominant_angles, extract_features, rectangles_in_frame
from rectmerge.robust.reasons import MapFacts

STRONG = 0.5  # a second direction is as good as the first from this share of its contrast


@dataclass(frozen=True, slots=True, eq=False)
class PreparedMap:
    """A map with what was read off it: the directions in which its walls pile up, and the frames of the strong ones."""

    grid: OccupancyGrid
    cells: MapCells
    quality: MapQuality
    features: Features | None
    angles: Sequence[tuple[float, float]] = ()
    frames: Sequence[Frame] = ()

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, cells: MapCells, quality: MapQuality, rectangles: int) -> PreparedMap:
        """Find what the method needs of a map; no features where no wall borders on free space."""
        features = extract_features(cells)
        if features is None:
            return cls(grid, cells, quality, None)
        angles = dominant_angles(features)
        strong = [angle for angle, contrast in angles[:2] if contrast >= STRONG * angles[0][1]]
        return cls(
            grid,
            cells,
            quality,
            features,
            angles,
            [rectangles_in_frame(features, at, most=rectangles) for at in strong],
        )

    @property
    def frame_angles(self) -> list[float]:
        """The angles of the strong frames, radians."""
        return [frame.angle for frame in self.frames]

    def all_frames(self, rectangles: int) -> list[Frame]:
        """Return the frames of all directions in which walls pile up, the strong ones first."""
        weak = self.angles[len(self.frames) :]
        return [*self.frames, *(rectangles_in_frame(self.walled, angle, most=rectangles) for angle, _ in weak)]

    @property
    def contrast(self) -> float:
        """How much the walls pile up along the first frame."""
        return self.angles[0][1]

    @property
    def facts(self) -> MapFacts:
        """What a reason may name."""
        free_cells = int(np.count_nonzero(self.walled.free))
        return MapFacts(free_cells=free_cells, roughness=self.cells.roughness())

    @property
    def thickness_cells(self) -> float:
        """How thick the walls are."""
        return self.quality.wall_thickness_cells or 1.0

    @property
    def walled(self) -> Features:
        """The features of a map that has walls."""
        assert self.features is not None
        return self.features

    @property
    def rank(self) -> tuple[float, ...]:
        """An order of maps that does not depend on which of two is called A."""
        return len(self.walled.walls), self.grid.occupancy.size, float(self.walled.walls.sum())
