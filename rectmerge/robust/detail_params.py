"""Parameters of the contradictions between two maps: the detailed grid of each, and what is counted between them."""

from __future__ import annotations

from dataclasses import dataclass

from rectmerge.declaration import HAND, LAYOUT, Group, param


@dataclass(frozen=True, slots=True, kw_only=True)
class DetailParams(Group):
    """Detailed grid of one map, with the faces and corners that another map may contradict."""

    diagonal_cells: float = param(
        700.0, "cells", LAYOUT, most=4000
    )  # of the detailed grid, at most the map's own cells
    margin_cells: int = param(6, "detailed cells", LAYOUT, most=1000)  # of unknown around the grid
    free_share: float = param(0.3, "share of a cell's area", HAND)  # seen free that makes a detailed cell free
    max_speck_cells: int = param(4, "detailed cells", HAND, least=0)  # of an obstacle that counts as free
    blur_cells: float = param(1.5, "detailed cells", HAND)  # before slopes are taken
    min_slope: float = param(0.05, "states per cell", HAND)  # of a face
    free_at_cells: float = param(3.0, "detailed cells", HAND)  # in front of a face
    max_off_deg: float = param(25.0, "degrees", HAND)  # of a long face from the strongest direction
    min_run_cells: float = param(20.0, "cells", HAND)  # of a long face
    run_width_cells: float = param(3.0, "cells", HAND)  # sideways spread of a run
    run_gap_cells: float = param(4.0, "cells", HAND)  # interruption of a run
    corner_blur_cells: float = param(1.5, "cells", HAND)  # or detailed cells, whichever is more
    corner_edge_weight: float = param(0.06, "share", "Harris and Stephens 1988: 0.04 to 0.06")
    corner_percentile: float = param(99.0, "percent", HAND)  # of the response on walls, which stands for the strongest
    corner_share: float = param(0.02, "share of the strongest response", HAND)  # of a corner
    corner_apart_cells: int = param(9, "detailed cells", HAND, most=99)
    corner_window_cells: int = param(11, "detailed cells", HAND, most=99)  # mostly free about a jamb


@dataclass(frozen=True, slots=True, kw_only=True)
class ContradictParams(Group):
    """Contradictions between the detailed grids, in cells of the coarser one."""

    face_reaches_cells: tuple[float, ...] = param(
        (2.0, 5.0, 3.0), "detailed cells", HAND, length=3
    )  # judged in unknown space; from walls and unknown space to solid floor; from a partner to beside it
    corner_reaches_cells: tuple[float, ...] = param(
        (2.0, 3.0, 4.0), "detailed cells", HAND, length=3
    )  # hidden near unknown space; of a partner; to a corner of the other kind, and unknown space, when denied
    added_corners: float = param(2.0, "corners", HAND)  # to the number shown, so that one missed of one is no proof
    max_faces: int = param(2000, "faces", LAYOUT)  # of each map, evenly spaced
