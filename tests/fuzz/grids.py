"""Grids that are hard on readers of maps: nothing that a robot would draw, everything that a program may meet."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN

Cells = NDArray[np.int8]


def checkerboard(side: int) -> Cells:
    return np.where(np.indices((side, side)).sum(axis=0) % 2, OCCUPIED, FREE).astype(np.int8)


def stripes(side: int, width: int = 3) -> Cells:
    return np.where(np.indices((side, side))[0] // width % 2, OCCUPIED, FREE).astype(np.int8)


def spiral(side: int, corridor: int = 3) -> Cells:
    """A single corridor that winds to the middle between walls of one cell."""
    cells = np.full((side, side), FREE, np.int8)
    ring, step = 0, corridor + 1
    while side - 2 * ring > 2 * step:
        low, high = ring, side - 1 - ring
        cells[low, low : high + 1] = cells[high, low : high + 1] = OCCUPIED
        cells[low : high + 1, low] = cells[low : high + 1, high] = OCCUPIED
        if ring:
            cells[low + 1 : low + 1 + corridor, low] = FREE  # the way in
        ring += step
    return cells


def one_free_cell(side: int) -> Cells:
    cells = np.full((side, side), UNKNOWN, np.int8)
    cells[side // 2, side // 3] = FREE
    return cells


def all_free(side: int) -> Cells:
    return np.full((side, side), FREE, np.int8)


def corridor_in_rock(side: int) -> Cells:
    cells = np.full((side, side), OCCUPIED, np.int8)
    cells[side // 2 : side // 2 + 4, 2:-2] = FREE
    return cells


def room(side: int) -> Cells:
    cells = np.full((side, side), OCCUPIED, np.int8)
    cells[1:-1, 1:-1] = FREE
    return cells


def ribbon(rows: int, length: int = 10_000) -> Cells:
    cells = np.full((rows, length), FREE, np.int8)
    cells[:, ::97] = OCCUPIED
    return cells


def noise(side: int, walls: float = 0.3, unknown: float = 0.3, seed: int = 0) -> Cells:
    drawn = np.random.default_rng(seed).random((side, side))
    return np.where(drawn < walls, OCCUPIED, np.where(drawn < walls + unknown, UNKNOWN, FREE)).astype(np.int8)


def dust(side: int, seed: int = 0) -> Cells:
    """Free space with single walls strewn over it."""
    return noise(side, 0.01, 0.0, seed)


def comb(side: int) -> Cells:
    """Teeth of every length: as many maximal rectangles as there are columns."""
    rows, cols = np.indices((side, side))
    return np.where(rows < (cols * 7919) % side, OCCUPIED, FREE).astype(np.int8)


def stairs(side: int) -> Cells:
    """A triangle of free cells: the most maximal rectangles that a shape can have."""
    rows, cols = np.indices((side, side))
    return np.where(rows + cols < side, FREE, OCCUPIED).astype(np.int8)


def lattice(side: int, step: int = 8) -> Cells:
    """Equal rooms without end: every shift by a room explains everything."""
    cells = np.full((side, side), FREE, np.int8)
    cells[::step] = cells[:, ::step] = OCCUPIED
    return cells


ADVERSARIES: dict[str, Callable[[int], Cells]] = {
    "checkerboard": checkerboard,
    "stripes": stripes,
    "spiral": spiral,
    "one free cell": one_free_cell,
    "all free": all_free,
    "corridor in rock": corridor_in_rock,
    "room": room,
    "noise": noise,
    "sparse noise": lambda side: noise(side, 0.02, 0.9),
    "dense noise": lambda side: noise(side, 0.9, 0.05),
    "dust": dust,
    "comb": comb,
    "stairs": stairs,
    "lattice": lattice,
}
