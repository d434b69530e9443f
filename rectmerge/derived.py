"""Cache of what methods derive from a map, for as long as one piece of work may ask for it again.

Aligning two maps may search twice, and a fleet asks about each map many times: what a method makes of a map alone is
made once in such a piece of work, and forgotten after it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

from rectmerge.grid import OccupancyGrid

MOST_CELLS_KEPT = 40_000_000  # of all maps that something is kept of: about 50 bytes of memory a cell
Value = TypeVar("Value")
_Kept = OrderedDict[tuple[OccupancyGrid, Hashable], Any]
_kept: ContextVar[_Kept | None] = ContextVar("kept", default=None)


@contextmanager
def derived_kept() -> Iterator[None]:
    """Keep what is derived from maps until the block ends; a block within another changes nothing."""
    if _kept.get() is not None:
        yield
        return
    token = _kept.set(OrderedDict())
    try:
        yield
    finally:
        _kept.reset(token)


def derive(grid: OccupancyGrid, what: Hashable, make: Callable[[], Value]) -> Value:
    """Return what `make` makes of a map: made anew, or kept from before within `derived_kept`.

    Parameters
    ----------
    grid
        The map, as an object: an equal one is another.
    what
        Says what is made and by which parameters.
    make
        Makes it.
    """
    kept = _kept.get()
    if kept is None:
        return make()
    value: Value = kept.pop((grid, what)) if (grid, what) in kept else make()
    kept[grid, what] = value  # the last to go
    while len(kept) > 1 and sum(each.occupancy.size for each, _ in kept) > MOST_CELLS_KEPT:
        kept.popitem(last=False)
    return value
