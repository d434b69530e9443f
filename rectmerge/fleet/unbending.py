"""Bending of the maps of a component onto each other, after they were placed."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.compose import merge_grids
from rectmerge.composing.resampling import known_ends
from rectmerge.elastic.bend import Bend
from rectmerge.elastic.params import BendParams
from rectmerge.elastic.unbend import DEFAULT_PARAMS, unbend
from rectmerge.errors import InputError
from rectmerge.fleet.graph import AlignmentGraph, Placement
from rectmerge.grid import UNKNOWN, OccupancyGrid, map_frame_to_pixels


def unbend_many(
    maps: Mapping[str, OccupancyGrid],
    graph: AlignmentGraph,
    *,
    params: BendParams = DEFAULT_PARAMS,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Bend]:
    """Bend the maps of each component onto the merged map of the others; the references stay.

    The maps are merged one after the other: next comes the one that agrees with most of those before. Those that did
    not bend are tried again on the merged map of the others, as long as one bends that they meet.

    Parameters
    ----------
    maps
        The maps by name.
    graph
        What `rectmerge.align_many` answered on them.
    params
        Weights, steps and thresholds of a bend.
    progress
        Called with the number of maps tried so far, again and again.

    Returns
    -------
    dict
        The bend of each placed map but the references, in the order of the components. It is truthy where the walls
        confirm it; `Bend.straighten` gives the map to compose in its place.

    Raises
    ------
    InputError
        If a placed map is not among the maps.
    """
    if missing := [name for name in graph.placements if name not in maps]:
        raise InputError(f"{missing[0]}: is placed, but is not among the maps")
    tried, bends = itertools.count(1), dict[str, Bend]()

    def note() -> None:
        if progress is not None:
            progress(next(tried))

    for names in graph.components:
        mosaic = _Mosaic(graph.placements, {name: maps[name] for name in names}, params, note)
        of_component = mosaic.lay_all()
        bends |= {name: of_component[name] for name in names[1:]}
    return bends


class _Mosaic:
    """Merged map of a component, laid map by map.

    Parameters
    ----------
    placements
        Placements by name.
    maps
        The maps of the component by name, the reference first.
    params
        Weights, steps and thresholds of a bend.
    note
        Called after each map that was tried.
    """

    def __init__(
        self,
        placements: Mapping[str, Placement],
        maps: Mapping[str, OccupancyGrid],
        params: BendParams,
        note: Callable[[], None],
    ) -> None:
        self._maps, self._params, self._note = maps, params, note
        self._places = {name: placements[name].to_reference for name in maps}
        self._boxes = {name: self._box(name) for name in maps}
        self._agreeing = {name: {a if b == name else b for a, b in placements[name].rests_on} for name in maps}
        reference = next(iter(maps))
        self._frame = replace(maps[reference], occupancy=np.full((1, 1), UNKNOWN, np.int8))  # that of what is merged
        self._straight = {reference: maps[reference]}
        self._bends: dict[str, Bend] = {}

    def lay_all(self) -> Mapping[str, Bend]:
        """Lay every map, and return their bends."""
        while waiting := [name for name in self._maps if name not in self._straight]:
            self._lay(max(waiting, key=lambda name: len(self._agreeing[name] & self._straight.keys())))
        moved = [name for name, bend in self._bends.items() if bend]
        while moved:
            refused = [name for name, bend in self._bends.items() if not bend]
            again = [name for name in refused if any(self._meets(name, other) for other in moved)]
            moved = [name for name in again if self._lay(name)]
        return self._bends

    def _lay(self, name: str) -> bool:
        """Bend a map onto the merged map of those that it meets, and lay it; return whether it bends."""
        others = [other for other in self._straight if other != name and self._meets(other, name)]
        grids, places = [self._straight[other] for other in others], [self._places[other] for other in others]
        merged = merge_grids([self._frame, *grids], [None, *places], rule="log-odds")
        pixels = map_frame_to_pixels(self._places[name], merged, self._maps[name])
        bend = unbend(merged, self._maps[name], pixels, params=self._params)
        self._bends[name], self._straight[name] = bend, bend.straighten(self._maps[name])
        self._note()
        return bend.accepted

    def _meets(self, one: str, other: str) -> bool:
        """Return whether the boxes around what two maps know meet."""
        (low, high), (others_low, others_high) = self._boxes[one], self._boxes[other]
        return bool((low <= others_high).all() and (others_low <= high).all())

    def _box(self, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the least and greatest (x, y) of what a map knows, in the reference's frame."""
        grid = self._maps[name]
        ends = self._places[name].apply(grid.pixel_to_map(known_ends(grid)))
        return ends.min(axis=0, initial=np.inf), ends.max(axis=0, initial=-np.inf)
