"""Composition of aligned grids in the first grid's frame, with the layer of their conflicts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, cast, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import CONFLICT_REACH_CELLS
from rectmerge.composing.resampling import resample
from rectmerge.composing.rules import RULES as RULES  # the names that callers of compose need
from rectmerge.composing.rules import Rule as Rule
from rectmerge.composing.rules import merge_layers
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity

CellsOf = Literal["a", "b", "finer"]
FINER_BELOW = 0.99  # cells this close in size to A's are not finer: A's own are kept


@dataclass(frozen=True, slots=True, eq=False)
class Composition:
    """A map merged from several, with its conflicts.

    Parameters
    ----------
    grid
        The merged map: A's frame, and by default A's cells, extended by whole cells.
    conflict
        Shape of `grid`: cells where one map has a wall and another has free space with no wall within 2 cells of A.
    corner
        (row, col) of the cell of `grid` that holds A's top-left corner: by default A's own top-left cell.
    conflict_mass
        Under the rule "evidence", for each cell of `grid` the mass of conflict, float32, 0..1, and 0 where fewer than
        two maps know the cell. None under the other rules.
    """

    grid: OccupancyGrid
    conflict: NDArray[np.bool_]
    corner: tuple[int, int]
    conflict_mass: NDArray[np.float32] | None = None


def compose(
    grids: Sequence[OccupancyGrid],
    b_to_as: Sequence[Similarity | None],
    *,
    rule: Rule = "occupied",
    resolution: CellsOf | float = "a",
) -> Composition:
    """Merge aligned grids into one in the first grid's frame, by default on its own cells.

    Parameters
    ----------
    grids
        The maps, A first, at least one.
    b_to_as
        For each map, the similarity from its map frame to A's; None for A itself, and only for A.
    rule
        Where maps contradict each other: "occupied" lets a wall win, "free" lets free space win, "newest" the later map
        in the list, "log-odds" sums the maps' log-odds, and "evidence" combines their masses by Dempster's rule and
        returns the mass of conflict. A cell known to a single map keeps that map's value under every rule.
    resolution
        The cells of the merged map: "a" keeps A's, one by one; "b" makes them as large as those of the second map,
        "finer" as those of the finest; or their side in metres (in cells of A, where A's resolution is not known). The
        size of another map's cells follows from its resolution, or where A or that map has none, from the placement.
        A's frame stays: a point of A's map has the same coordinates on the merged one.

    Raises
    ------
    InputError
        If the lists do not match, the rule or the resolution is invalid, or the merged map would be absurdly large.

    Notes
    -----
    `rectmerge.composing.resampling.resample` reads the cells and keeps thin walls closed;
    `rectmerge.composing.rules.merge_layers` has the rules. Where A's resolution is not known and the cells are not A's,
    the `resolution` of the merged map is in cells of A, so that A's frame stays.
    """
    _check(grids, b_to_as, rule)
    layers, corner, lattice, size = _lay(grids, b_to_as, resolution)
    merged, mass = merge_layers(layers, rule)
    reach = max(1, round(CONFLICT_REACH_CELLS * lattice.scale))
    grid = _in_frame_of(grids[0], merged, corner, lattice, size)
    return Composition(grid, find_conflict(layers, reach=reach), corner, mass)


def merge_grids(
    grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], *, rule: Rule = "occupied"
) -> OccupancyGrid:
    """Merge aligned grids as `compose` does, without the layer of their conflicts, which takes each pair of them."""
    _check(grids, b_to_as, rule)
    layers, corner, lattice, size = _lay(grids, b_to_as, "a")
    return _in_frame_of(grids[0], merge_layers(layers, rule)[0], corner, lattice, size)


def parse_resolution(text: str) -> CellsOf | float:
    """Parse the `resolution` of `compose` from text: a, b, finer or a number.

    Raises
    ------
    InputError
        If it is none of these.
    """
    if text in get_args(CellsOf):
        return cast("CellsOf", text)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise InputError(f"{text!r} is not a, b, finer or a positive number of metres per cell")
    return number


def _lay(
    grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], resolution: CellsOf | float
) -> tuple[Sequence[NDArray[np.int8]], tuple[int, int], Similarity, float]:
    """Lay grids on merged cells; return the layers, A's corner, the place of A's pixels, and the side of a cell."""
    a, size = grids[0], _cell_size(grids, b_to_as, resolution)
    lattice = _lattice(a, a.cell_size / size)
    placements = [
        lattice if t is None else lattice @ map_frame_to_pixels(t, a, g) for g, t in zip(grids, b_to_as, strict=True)
    ]
    layers, corner = resample(grids, placements)
    return layers, corner, lattice, size


def _in_frame_of(
    a: OccupancyGrid, merged: NDArray[np.int8], corner: tuple[int, int], lattice: Similarity, size: float
) -> OccupancyGrid:
    row, col = corner
    x, y = a.pixel_to_map(lattice.inverse().apply([-col - 0.5, merged.shape[0] - row - 0.5]))
    return OccupancyGrid(merged, a.resolution if size == a.cell_size else size, (float(x), float(y), a.origin[2]))


def _check(grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], rule: str) -> None:
    if rule not in RULES:
        raise InputError(f"rule must be one of {', '.join(RULES)}, got {rule!r}")
    if not grids or len(grids) != len(b_to_as):
        raise InputError(f"compose needs one b_to_a per grid (None for the first), got {len(grids)} and {len(b_to_as)}")
    if b_to_as[0] is not None or any(t is None for t in b_to_as[1:]):
        raise InputError(
            "b_to_as must be None for the first grid, whose frame is kept, and a Similarity for the others"
        )


def _cell_size(
    grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], resolution: CellsOf | float
) -> float:
    """Return the side of a merged cell in units of A's map frame."""
    a = grids[0]
    stated = [a.resolution is not None and g.resolution is not None for g in grids]
    sizes = [g.cell_size * (1.0 if t is None or s else t.scale) for g, t, s in zip(grids, b_to_as, stated, strict=True)]
    if resolution == "b" and len(grids) < 2:
        raise InputError("resolution 'b' is that of the second map, and there is only one")
    if resolution == "finer":
        return min(sizes) if min(sizes) < FINER_BELOW * a.cell_size else a.cell_size
    if resolution in ("a", "b"):
        return sizes[("a", "b").index(resolution)]
    if isinstance(resolution, str) or not (math.isfinite(resolution) and resolution > 0):
        raise InputError(f"resolution must be 'a', 'b', 'finer' or a positive number, got {resolution!r}")
    return float(resolution)


def _lattice(a: OccupancyGrid, factor: float) -> Similarity:
    """Return the similarity from A's pixels to those of `factor` merged cells per cell, which share A's lower left."""
    height = a.shape[0]
    rows = math.ceil(factor * height - 1e-6)
    return Similarity(factor, 0.0, (factor - 1) / 2, rows - 0.5 - factor * (height - 0.5))


def find_conflict(layers: Sequence[NDArray[np.int8]], *, reach: int = CONFLICT_REACH_CELLS) -> NDArray[np.bool_]:
    """Mark walls of one layer, shape (H, W), on free space of another that has no wall within `reach` cells."""
    size = 2 * reach + 1
    views = [OccupancyGrid(layer) for layer in layers]
    near = [cv2.dilate(g.occupied.view(np.uint8), np.ones((size, size), np.uint8)).view(np.bool_) for g in views]
    conflict = np.zeros(layers[0].shape, np.bool_)
    for i, j in combinations(range(len(views)), 2):
        conflict |= views[i].occupied & views[j].free & ~near[j]
        conflict |= views[j].occupied & views[i].free & ~near[i]
    return conflict
