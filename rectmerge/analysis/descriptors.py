"""Descriptors of a map, free of its size: specks and their places, pinholes, slivers, frontiers, gaps in walls.

They compare populations of maps, as simulated ones with those that robots made.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.analysis.overlap import cells_of
from rectmerge.analysis.quality import measure_quality
from rectmerge.grid import OccupancyGrid

Mask = NDArray[np.bool_]

# source of all: hand; the limits of specks and blobs are those that maps in public repositories were first counted by
MAX_SPECK_CELLS = 4  # of a speck, cells that touch at a corner counted together
MAX_PINHOLE_CELLS = 8  # of a pinhole, cells that share a side counted together
MAX_HOLE_CELLS = 1000  # of a hole, likewise
BLOB_CELLS = (5, 150)  # least and most cells of a blob
NEAR_WALL_CELLS = 5.0
SHORT_GAP_CELLS, GAP_CELLS = 3, 7  # sides of the squares of both closings: gaps of up to 2 and 6 cells
FEWEST_SPECKS = 5  # from which clumping is measured
SAMPLED_SPECKS = 1000  # evenly spaced specks whose neighbours are sought; trades time
REACH_CELLS = 5  # half the side of the square in which roughness is measured
MIN_LENGTH_CELLS = 2.0  # least standard deviation along a piece of wall face: longer than it is wide


@dataclass(frozen=True, slots=True)
class MapDescriptors:
    """Descriptors of one map; a figure is None where the map has nothing to measure it on.

    Parameters
    ----------
    specks
        Occupied patches of at most 4 cells, per 100 free cells.
    speck_clumping
        Mean distance from a speck to the next one, over that of as many specks spread evenly over the free space
        (P. J. Clark and F. C. Evans, Ecology 35, 1954, DOI 10.2307/1931034): below 1 in clumps.
    specks_near_walls
        Share of the specks within 5 cells of a larger occupied patch, 0..1.
    pinholes
        Unknown cells in patches of at most 8 cells, per 100 free cells.
    holes
        Unknown cells in patches of 9 to 1000 cells, per 100 free cells: insides of furniture and of walls, shadows.
    slivers
        Free cells that an opening by 3 x 3 cells removes, per 100 free cells: single rays, ragged frontiers.
    strays
        Free patches of at most 4 cells, per 100 free cells: pieces of rays beyond glass and thin walls.
    frontier_share
        Share of the free space's border, corners left out, beyond which lies unknown space, 0..1.
    blobs
        Occupied patches of 5 to 150 cells, per 10,000 free cells: furniture, pieces of walls.
    wall_thickness_cells
        Median thickness of the walls, in cells.
    wall_roughness_cells
        Median over pieces of wall face of the standard deviation across the piece, in cells: 0 on a straight wall
        along the rows, about 0.3 on an oblique one.
    short_gaps, gaps
        Cells that a closing of the walls by 3 x 3 cells fills, and those that one by 7 x 7 cells fills beyond, per 100
        occupied cells: gaps, rough faces, double and hollow walls.
    straightness
        As `rectmerge.analysis.quality.MapQuality` has it.
    """

    specks: float | None
    speck_clumping: float | None
    specks_near_walls: float | None
    pinholes: float | None
    holes: float | None
    slivers: float | None
    strays: float | None
    frontier_share: float | None
    blobs: float | None
    wall_thickness_cells: float | None
    wall_roughness_cells: float | None
    short_gaps: float | None
    gaps: float | None
    straightness: float | None

    def as_dict(self) -> dict[str, float]:
        """Return the measured figures, by name."""
        return {name: value for name, value in dataclasses.asdict(self).items() if value is not None}


def describe_map(grid: OccupancyGrid) -> MapDescriptors:
    """Measure the descriptors of a map from its cells alone.

    Examples
    --------
    >>> occupancy = np.zeros((40, 50), np.int8)
    >>> occupancy[:, 0] = 100
    >>> occupancy[10, 10] = occupancy[20, 30] = 100  # two specks
    >>> describe_map(OccupancyGrid(occupancy)).specks
    0.102...
    """
    free, occupied, unknown = (np.ascontiguousarray(mask) for mask in (grid.free, grid.occupied, grid.unknown))
    free_cells, walls = int(free.sum()), _Patches(occupied, 8)
    of_unknown, of_free = _Patches(unknown, 4), _Patches(free, 8)
    quality = measure_quality(grid)
    clumping, near_walls = _speck_places(walls, free_cells)
    tiny, gaps = _gaps(occupied)

    def per(cells: int, free_cells_each: float) -> float | None:
        return free_cells_each * cells / free_cells if free_cells else None

    return MapDescriptors(
        specks=per(walls.count(1, MAX_SPECK_CELLS), 100),
        speck_clumping=clumping,
        specks_near_walls=near_walls,
        pinholes=per(of_unknown.cell_count(1, MAX_PINHOLE_CELLS), 100),
        holes=per(of_unknown.cell_count(MAX_PINHOLE_CELLS + 1, MAX_HOLE_CELLS), 100),
        slivers=per(int((free & ~_opened(free)).sum()), 100),
        strays=per(of_free.count(1, MAX_SPECK_CELLS), 100),
        frontier_share=_frontier_share(free, occupied, unknown),
        blobs=per(walls.count(*BLOB_CELLS), 10_000),
        wall_thickness_cells=quality.wall_thickness_cells,
        wall_roughness_cells=_roughness(free, occupied),
        short_gaps=tiny,
        gaps=gaps,
        straightness=quality.straightness,
    )


class _Patches:
    """Connected patches of a mask (H, W), with their numbers of cells and centroids."""

    def __init__(self, mask: Mask, connectivity: int) -> None:
        _, self.labels, stats, centroids = cv2.connectedComponentsWithStats(
            mask.view(np.uint8), connectivity=connectivity
        )
        self.cells = stats[:, cv2.CC_STAT_AREA].astype(np.int64)
        self.cells[0] = 0  # what is not the mask
        self.centroids = centroids  # (N, 2), (col, row)

    def of(self, least: int, most: int) -> Mask:
        """Mark the patches by their number of cells, shape (N,)."""
        return (self.cells >= least) & (self.cells <= most)

    def count(self, least: int, most: int) -> int:
        """Count the patches of a number of cells."""
        return int(self.of(least, most).sum())

    def cell_count(self, least: int, most: int) -> int:
        """Count the cells of these patches."""
        return int(self.cells[self.of(least, most)].sum())


def _speck_places(walls: _Patches, free_cells: int) -> tuple[float | None, float | None]:
    """Return the clumping of the specks and the share of them near walls."""
    are_specks = walls.of(1, MAX_SPECK_CELLS)
    places = walls.centroids[are_specks]  # (S, 2)
    if not len(places) or not free_cells:
        return None, None
    is_large = walls.cells > MAX_SPECK_CELLS
    near_walls = None
    if is_large.any():
        away = exact_distance(is_large[walls.labels])
        cols, rows = np.rint(places).astype(int).T
        near_walls = float((away[rows, cols] <= NEAR_WALL_CELLS).mean())
    if len(places) < FEWEST_SPECKS:
        return None, near_walls
    sampled = places[np.linspace(0, len(places) - 1, min(len(places), SAMPLED_SPECKS)).astype(int)]
    nearest = [_second_least(np.hypot(*(places - place).T)) for place in sampled]
    return float(np.mean(nearest)) / (0.5 * math.sqrt(free_cells / len(places))), near_walls


def _second_least(distances: NDArray[np.float64]) -> float:
    """Return the distance to the nearest other point, the point itself being at distance 0."""
    return float(np.partition(distances, 1)[1])


def _opened(mask: Mask) -> Mask:
    return cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)).astype(np.bool_)


def _closed(mask: Mask, side: int) -> Mask:
    padded = np.pad(mask, side).view(np.uint8)
    closed = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8)).astype(np.bool_)
    inner: Mask = closed[side:-side, side:-side]
    return inner


def _gaps(occupied: Mask) -> tuple[float | None, float | None]:
    """Return the cells of short and of longer gaps per 100 occupied cells."""
    wall_cells = int(occupied.sum())
    if not wall_cells:
        return None, None
    short, longer = (int(_closed(occupied, side).sum()) for side in (SHORT_GAP_CELLS, GAP_CELLS))
    return 100 * (short - wall_cells) / wall_cells, 100 * (longer - short) / wall_cells


def _frontier_share(free: Mask, occupied: Mask, unknown: Mask) -> float | None:
    """Return the share of the sides between free cells and others beyond which lies unknown space."""
    sides = {"unknown": 0, "occupied": 0}
    for name, other in (("unknown", unknown), ("occupied", occupied)):
        for mine, theirs in ((free, other), (free.T, other.T)):
            sides[name] += int((mine[1:] & theirs[:-1]).sum()) + int((mine[:-1] & theirs[1:]).sum())
    total = sum(sides.values())
    return sides["unknown"] / total if total else None


def _roughness(free: Mask, occupied: Mask) -> float | None:
    """Return the median standard deviation across pieces of wall face, cells."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    face = occupied & cv2.dilate(free.view(np.uint8), cross).astype(np.bool_)
    cells = cells_of(face, SAMPLED_SPECKS)
    if not len(cells):
        return None
    across, along = np.linalg.eigvalsh(_moments_at(face, cells)).T  # variances, ascending
    is_piece = along >= MIN_LENGTH_CELLS**2
    return float(np.median(np.sqrt(np.maximum(across[is_piece], 0.0)))) if is_piece.any() else None


def _moments_at(mask: Mask, cells: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the covariance of the mask's cells in squares about cells (N, 2), shape (N, 2, 2)."""
    offsets = np.arange(-REACH_CELLS, REACH_CELLS + 1)
    padded = np.pad(mask, REACH_CELLS)
    rows, cols = cells.T
    here = padded[
        rows[:, None, None] + REACH_CELLS + offsets[:, None], cols[:, None, None] + REACH_CELLS + offsets
    ].astype(np.float64)  # (N, 11, 11)
    total = here.sum(axis=(1, 2))
    v, u = (np.broadcast_to(axis, here.shape[1:]) for axis in (offsets[:, None], offsets))
    mean_v, mean_u, vv, uv, uu = (np.einsum("nij,ij->n", here, of) / total for of in (v, u, v * v, u * v, u * u))
    covariance = np.array([[vv - mean_v**2, uv - mean_u * mean_v], [uv - mean_u * mean_v, uu - mean_u**2]])
    moved: NDArray[np.float64] = np.moveaxis(covariance, 2, 0)
    return moved
