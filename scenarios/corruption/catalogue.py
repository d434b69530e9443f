"""Catalogue of the corruptions that any map can be given by name and strength.

To add one: write its function in `cells`, `clumps` or `geometry` and give it a line in `CORRUPTIONS`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption import cells, clumps, geometry
from scenarios.corruption.point_motions import CorruptedMap

PER_CELLS = 10_000  # rays and blobs are counted per this many known cells


class Corruption(NamedTuple):
    """Corruption: the unit of its strength, the allowed range, and the function that applies it."""

    unit: str
    low: float
    high: float
    apply: Callable[[OccupancyGrid, float, np.random.Generator], OccupancyGrid | CorruptedMap]


def _counted(
    apply: Callable[[OccupancyGrid, int, np.random.Generator], OccupancyGrid],
) -> Callable[[OccupancyGrid, float, np.random.Generator], OccupancyGrid]:
    """Adapt a corruption by count to a strength per `PER_CELLS` known cells."""
    return lambda grid, density, rng: apply(grid, round(density * int((~grid.unknown).sum()) / PER_CELLS), rng)


def _turned(grid: OccupancyGrid, degrees: float, _: np.random.Generator) -> CorruptedMap:
    turned, pixels = geometry.turn_image(grid, degrees)
    return CorruptedMap(turned, (pixels,))


CORRUPTIONS = {
    "salt": Corruption("share of the free cells", 0, 1, cells.salt),
    "wall_dropout": Corruption("share of the occupied cells", 0, 1, cells.wall_dropout),
    "wall_edge_flips": Corruption("share of the cells where free space and walls touch", 0, 1, cells.wall_edge_flips),
    "double_walls": Corruption("share of the occupied cells", 0, 1, cells.double_walls),
    "spurious_rays": Corruption("rays per 10,000 known cells", 0, 100, _counted(cells.spurious_rays)),
    "blobs": Corruption("discs per 10,000 known cells", 0, 100, _counted(cells.blobs)),
    "thick_walls": Corruption("share of the cells beside walls", 0, 1, clumps.thick_walls),
    "broken_walls": Corruption("share of the occupied cells", 0, 1, clumps.broken_walls),
    "pinholes": Corruption("share of the free cells", 0, 1, clumps.pinholes),
    "speck_clumps": Corruption("specks per 100 free cells", 0, 10, clumps.speck_clumps),
    "clutter": Corruption("patches per 10,000 free cells", 0, 100, clumps.clutter),
    "erosion": Corruption("cells off every side of the walls", 0, 20, lambda grid, r, _: cells.erosion(grid, r)),
    "dilation": Corruption("cells onto every side of the walls", 0, 20, lambda grid, r, _: cells.dilation(grid, r)),
    "bend": Corruption("degrees, where a wall turns most", 0, 10, geometry.bend),
    "stretch": Corruption("percent longer along one direction", -20, 20, geometry.stretch),
    "kink": Corruption("degrees, what lies beyond a line, counter-clockwise", -45, 45, geometry.kink),
    "resample": Corruption(
        "new cells per old cell along a side", 0.1, 10, lambda grid, f, _: geometry.resize_cells(grid, f)
    ),
    "turn": Corruption("degrees, the whole image, counter-clockwise", -360, 360, _turned),
}


def corrupt(grid: OccupancyGrid, corruptions: Iterable[tuple[str, float]], *, seed: int = 0) -> CorruptedMap:
    """Apply corruptions to a map, in order.

    Parameters
    ----------
    grid
        Any map, as `rectmerge.read_map` reads it.
    corruptions
        Pairs (name, strength). `CORRUPTIONS` holds the names, and the unit and the allowed range of each strength; the
        function of each says what it does.
    seed
        Seed of all randomness. Each position in the list draws from a stream of its own, so another strength at one
        position leaves the draws of the others as they are.

    Returns
    -------
    CorruptedMap
        The map, and `map_points`, which takes points of the given map to it.

    Raises
    ------
    InputError
        If a name is unknown, or a strength is not allowed.

    Examples
    --------
    >>> office = OccupancyGrid(np.zeros((80, 120), np.int8), 0.05)  # or rectmerge.read_map("office.yaml")
    >>> corrupted = corrupt(office, [("bend", 2.0), ("salt", 0.01)], seed=0)
    >>> corrupted.grid.shape
    (86, 126)
    >>> corrupted.map_points([[60.0, 40.0]]).round(2).tolist()  # the middle of the office, in pixels
    [[63.78, 41.81]]
    """
    steps = [(_corruption(name, strength), float(strength)) for name, strength in corruptions]
    current = CorruptedMap(grid)
    for (corruption, strength), stream in zip(steps, np.random.SeedSequence(seed).spawn(len(steps)), strict=True):
        result = corruption.apply(current.grid, strength, np.random.default_rng(stream))
        current = current.then(result if isinstance(result, CorruptedMap) else CorruptedMap(result))
    return current


def check_corruptions(corruptions: Iterable[tuple[str, float]]) -> None:
    """Refuse unknown names and strengths that are not allowed, as `corrupt` does."""
    for name, strength in corruptions:
        _corruption(name, strength)


def _corruption(name: str, strength: float) -> Corruption:
    if name not in CORRUPTIONS:
        raise InputError(f"no corruption {name!r}; there are: {', '.join(CORRUPTIONS)}")
    corruption = CORRUPTIONS[name]
    if not corruption.low <= strength <= corruption.high:
        raise InputError(f"{name} must be {corruption.low} to {corruption.high} ({corruption.unit}), got {strength}")
    return corruption
