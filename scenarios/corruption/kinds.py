"""Damage by name and strength, done to anybody's map."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption import cells, geometry
from scenarios.corruption.motions import Damaged

PER_CELLS = 10_000  # rays and blobs are counted per this many known cells


class Kind(NamedTuple):
    """A kind of damage: what its strength counts, the strengths that are allowed, and what does it."""

    unit: str
    low: float
    high: float
    do: Callable[[OccupancyGrid, float, np.random.Generator], OccupancyGrid | Damaged]


def _counted(
    do: Callable[[OccupancyGrid, int, np.random.Generator], OccupancyGrid],
) -> Callable[[OccupancyGrid, float, np.random.Generator], OccupancyGrid]:
    """Take a density for a count."""
    return lambda grid, density, rng: do(grid, round(density * int((~grid.unknown).sum()) / PER_CELLS), rng)


def _turned(grid: OccupancyGrid, degrees: float, _: np.random.Generator) -> Damaged:
    turned, pixels = geometry.turn_image(grid, degrees)
    return Damaged(turned, (pixels,))


KINDS = {
    "salt": Kind("share of the free cells", 0, 1, cells.salt),
    "wall_dropout": Kind("share of the occupied cells", 0, 1, cells.wall_dropout),
    "wall_edge_flips": Kind("share of the cells where free space and walls touch", 0, 1, cells.wall_edge_flips),
    "double_walls": Kind("share of the occupied cells", 0, 1, cells.double_walls),
    "spurious_rays": Kind("rays per 10,000 known cells", 0, 100, _counted(cells.spurious_rays)),
    "blobs": Kind("discs per 10,000 known cells", 0, 100, _counted(cells.blobs)),
    "erosion": Kind("cells off every side of the walls", 0, 20, lambda grid, r, _: cells.erosion(grid, r)),
    "dilation": Kind("cells onto every side of the walls", 0, 20, lambda grid, r, _: cells.dilation(grid, r)),
    "bend": Kind("degrees, where a wall turns most", 0, 10, geometry.bend),
    "stretch": Kind("percent longer along one direction", -20, 20, geometry.stretch),
    "kink": Kind("degrees, what lies beyond a line, counter-clockwise", -45, 45, geometry.kink),
    "resample": Kind("new cells per old cell along a side", 0.1, 10, lambda grid, f, _: geometry.resize_cells(grid, f)),
    "turn": Kind("degrees, the whole image, counter-clockwise", -360, 360, _turned),
}


def corrupt(grid: OccupancyGrid, damages: Iterable[tuple[str, float]], *, seed: int = 0) -> Damaged:
    """Damage a map, one kind after the other.

    Parameters
    ----------
    grid
        Any map, as `rectmerge.read_map` reads it.
    damages
        Pairs (kind, strength). `KINDS` tells what the strength of each counts and which strengths are allowed.

        ===================  =============================================================================
        salt                 share of the free cells that turn occupied
        wall_dropout         share of the occupied cells that turn unknown
        wall_edge_flips      share of the cells where free space and walls touch that flip
        double_walls         share of the walls that are drawn a second time, 2 to 4 cells aside
        spurious_rays        free rays through everything, 20 to 80 cells long, per 10,000 known cells
        blobs                discs of 2 to 5 cells radius, occupied or unknown, per 10,000 known cells
        erosion, dilation    cells taken off, or added to, every side of the walls; walls thin enough vanish
        bend                 degrees that a wall turns where it turns most; smooth, as a drifting heading bends
        stretch              percent that the map is longer along one direction
        kink                 degrees that everything beyond a line turns; torn, as a lost heading bends
        resample             new cells per old cell along a side
        turn                 degrees that the whole image turns, counter-clockwise to the eye
        ===================  =============================================================================
    seed
        Of all that is random. Each place in the list draws from a stream of its own, so another strength in one place
        leaves the draws of the others as they are.

    Returns
    -------
    Damaged
        The map, and `moved`, which tells where points of the given map went.

    Raises
    ------
    InputError
        If there is no such kind, or a strength is not allowed.

    Examples
    --------
    >>> office = OccupancyGrid(np.zeros((80, 120), np.int8), 0.05)  # or rectmerge.read_map("office.yaml")
    >>> damaged = corrupt(office, [("bend", 2.0), ("salt", 0.01)], seed=0)
    >>> damaged.grid.shape
    (86, 126)
    >>> damaged.moved([[60.0, 40.0]]).round(2).tolist()  # where the middle of the office went, in pixels
    [[63.78, 41.81]]
    """
    wanted = [(_kind(name, strength), float(strength)) for name, strength in damages]
    done = Damaged(grid)
    for (kind, strength), stream in zip(wanted, np.random.SeedSequence(seed).spawn(len(wanted)), strict=True):
        result = kind.do(done.grid, strength, np.random.default_rng(stream))
        done = done.then(result if isinstance(result, Damaged) else Damaged(result))
    return done


def check_damages(damages: Iterable[tuple[str, float]]) -> None:
    """Refuse kinds that there are not, and strengths that are not allowed, as `corrupt` does."""
    for name, strength in damages:
        _kind(name, strength)


def _kind(name: str, strength: float) -> Kind:
    if name not in KINDS:
        raise InputError(f"no damage {name!r}; there are: {', '.join(KINDS)}")
    kind = KINDS[name]
    if not kind.low <= strength <= kind.high:
        raise InputError(f"{name} must be {kind.low} to {kind.high} ({kind.unit}), got {strength}")
    return kind
