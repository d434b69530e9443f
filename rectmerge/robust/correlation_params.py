"""Parameters of the correlation of two maps over every shift, at a few angles and at angles all round."""

from __future__ import annotations

from dataclasses import dataclass

from rectmerge.declaration import HAND, LAYOUT, Group, ablation, param

MEETING = "31 of 239 pairs of real_places lie at another angle than the strongest directions: all keep theirs"


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrelateParams(Group):
    """Correlation of the faces of both maps over every shift."""

    cell_cells: float = param(3.0, "cells", LAYOUT)  # working cells per correlated cell
    max_diagonal_cells: float = param(180.0, "correlated cells", LAYOUT, most=1000)  # larger maps take larger cells
    spread_cells: float = param(1.0, "correlated cells", HAND)
    outliers: float = param(0.03, "share", HAND)
    scale_step: float = param(0.04, "log scale", HAND, least=0.001)
    shifts_per_scale: int = param(8, "placements", LAYOUT)  # kept of each scale and quarter turn
    max_correlation_fits: int = param(48, "placements", LAYOUT, most=100_000)  # refined
    rival_shifts: int = param(5, "placements", ablation("rivals at the same scale"))  # kept of each quarter turn
    max_rival_fits: int = param(20, "placements", LAYOUT, most=100_000)  # refined
    reaches_cells: tuple[float, ...] = param((8.0, 6.0, 6.0, 4.0, 4.0, 3.0, 3.0, 2.0, 2.0), "cells", HAND)


@dataclass(frozen=True, slots=True, kw_only=True)
class AllRoundParams(Group):
    """Correlation of the faces of both maps at angles all round, the last stage of the search."""

    is_used: bool = param(True, "switch", ablation("all angles"))
    turn_step_deg: float = param(6.0, "degrees", LAYOUT, least=0.1, most=45)
    cell_cells: float = param(4.0, "cells", LAYOUT)  # working cells per correlated cell
    max_diagonal_cells: float = param(100.0, "correlated cells", LAYOUT, most=1000)  # larger maps take larger cells
    spread_cells: float = param(1.0, "correlated cells", HAND)
    weak_contrast: float = param(0.25, "contrast", MEETING)  # of directions; below it all angles are tried
    meeting_reach_deg: int = param(4, "degrees", MEETING, least=1, most=45)  # within which two directions meet, some
    min_meeting_share: float = param(0.2, "share of the most", MEETING)  # of directions that an angle joins
    scale_step: float = param(0.12, "log scale", HAND, least=0.001)
    shifts_per_scale: int = param(4, "placements", LAYOUT)  # kept of each angle, scale and quarter turn
    max_fits: int = param(150, "placements", LAYOUT, most=100_000)  # refined
