"""Merge 2-D occupancy grids of unknown rotation, scale and translation by the rectangles of their free space."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rectmerge.aligning import align, check
    from rectmerge.alignment import Alignment, Candidate
    from rectmerge.composing.compose import compose
    from rectmerge.elastic.bend import Bend
    from rectmerge.elastic.unbend import unbend
    from rectmerge.errors import InputError, MapFileError, MethodError, RectMergeError
    from rectmerge.fleet.graph import AlignmentGraph
    from rectmerge.fleet.many import align_many
    from rectmerge.fleet.unbending import unbend_many
    from rectmerge.grid import OccupancyGrid
    from rectmerge.io.map_file import read_map, write_map
    from rectmerge.methods import make_method
    from rectmerge.similarity import Similarity

__version__ = "0.1.0"
_HOME = {
    "Alignment": "alignment",
    "AlignmentGraph": "fleet.graph",
    "Bend": "elastic.bend",
    "Candidate": "alignment",
    "InputError": "errors",
    "MapFileError": "errors",
    "MethodError": "errors",
    "OccupancyGrid": "grid",
    "RectMergeError": "errors",
    "Similarity": "similarity",
    "align": "aligning",
    "align_many": "fleet.many",
    "check": "aligning",
    "compose": "composing.compose",
    "make_method": "methods",
    "read_map": "io.map_file",
    "unbend": "elastic.unbend",
    "unbend_many": "fleet.unbending",
    "write_map": "io.map_file",
}
__all__ = [
    "Alignment",
    "AlignmentGraph",
    "Bend",
    "Candidate",
    "InputError",
    "MapFileError",
    "MethodError",
    "OccupancyGrid",
    "RectMergeError",
    "Similarity",
    "align",
    "align_many",
    "check",
    "compose",
    "make_method",
    "read_map",
    "unbend",
    "unbend_many",
    "write_map",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'rectmerge' has no attribute {name!r}")
    return getattr(importlib.import_module(f"rectmerge.{_HOME[name]}"), name)
