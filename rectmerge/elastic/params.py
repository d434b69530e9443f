"""Parameters of the elastic alignment, by stage, each with its unit and its source."""

from __future__ import annotations

from dataclasses import dataclass, field

from rectmerge.declaration import HAND, Group, param
from rectmerge.errors import InputError

INSENSITIVE = "tried on hand-held maps of several places; insensitive within a factor of 2"
CHOSEN = "hand-held maps of three places, against each other and laid on other places by force"


@dataclass(frozen=True, slots=True, kw_only=True)
class FaceParams(Group):
    """Wall faces and their partners."""

    normal_reach_cells: int = param(3, "cells of the map", INSENSITIVE)
    same_normal_cos: float = param(0.5, "cosine, within which normals are averaged", HAND)
    directions: int = param(8, "directions of the labelled distance transforms", HAND)
    direction_cos: float = param(0.6, "cosine to the middle of a direction", HAND)
    label_diagonal_cells: int = param(500, "cells of the labels' diagonal", HAND)
    label_margin: float = param(
        0.1, "share of the walls' diagonal around them that has labels", "twice the first reach"
    )
    max_faces: int = param(1200, "faces of each map", INSENSITIVE)
    pair_cos: float = param(0.6, "cosine between partners", HAND)
    margin: float = param(0.04, "share of the diagonal around the other map's walls", HAND)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitParams(Group):
    """Energy of the displacement and its minimisation; D is the diagonal of A's walls."""

    spacing: float = param(1 / 12, "D, between nodes of the lattice", INSENSITIVE)
    beyond: float = param(0.5, "D, by which the lattice may extend beyond A's walls", "hand; bounds time and memory")
    patch: float = param(1 / 8, "D: areas of this side bend independently", INSENSITIVE)
    strain_std: float = param(0.025, "strain", INSENSITIVE)
    turn_std: float = param(0.05, "radians per patch", INSENSITIVE)
    curvature_weight: float = param(0.25, "weight of second derivatives, by strain_std over a patch", HAND)
    wall_std_cells: float = param(1.5, "cells of A", INSENSITIVE)
    along_weight: float = param(0.2, "weight of the distance along the wall", INSENSITIVE)
    behind_weight: float = param(0.5, "weight of a face that lies behind a wall of the other map", INSENSITIVE)
    correlated_cells: float = param(
        7.0, "cells of a wall that count as one measurement", "hand-held maps, real and simulated: 20 is too stiff"
    )
    reaches: tuple[float, ...] = param(
        (0.05,) * 2 + (0.03,) * 2 + (0.02,) * 2 + (0.016,) * 3, "D; one step each", INSENSITIVE
    )
    stiffness: tuple[float, ...] = param(
        (4.0,) * 2 + (2.0,) * 2 + (1.0,) * 5, "factor of the prior, one per step", INSENSITIVE
    )

    def __post_init__(self) -> None:
        Group.__post_init__(self)
        if len(self.reaches) != len(self.stiffness):
            raise InputError(
                f"there must be one stiffness for each reach, got {len(self.reaches)} and {len(self.stiffness)}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceParams(Group):
    """Test of a displacement on walls that it was not fitted to."""

    square: float = param(1 / 8, "D, side of the squares of the cross-validation", INSENSITIVE)
    cost_reach: float = param(0.012, "D, distance from which a wall costs all", CHOSEN)
    min_cost_reach_cells: float = param(4.0, "cells of A, least reach, for small maps", HAND)
    max_cost_ratio: float = param(
        0.96, "held-back cost after over before", CHOSEN + "; 0.93 refuses maps that bend by few cells"
    )
    min_gain_t: float = param(1.0, "mean over standard error of the squares' gains", CHOSEN)
    min_met: float = param(0.415, "share of the walls that meet, held back", CHOSEN)
    min_squares: int = param(11, "squares that show walls of both maps", CHOSEN)
    min_determinant: float = param(0.5, "determinant of the Jacobian", HAND)
    min_stretch: float = param(0.65, "singular value of the Jacobian", HAND)
    max_stretch: float = param(1.4, "singular value of the Jacobian", HAND)
    min_square_faces: int = param(8, "faces of a square that counts", HAND)
    min_distance_cells: float = param(
        0.9, "cells of A, upper quartile of the walls' distances", "rigid simulated maps reach 0.83"
    )
    clear_distance_cells: float = param(1.5, "the same; maps clearly bend", "lasers reach 1.4, hand-held begin at 1.8")
    unclear_gain_t: float = param(2.0, "min_gain_t of maps between the two", "rigid lasers reach 1.2")
    min_faces: int = param(100, "faces with a partner, of both maps", HAND)

    def reach_cells(self, diagonal: float) -> float:
        """Return the distance from which a wall costs all, in cells of A, given the diagonal of A's walls."""
        return max(self.cost_reach * diagonal, self.min_cost_reach_cells)


@dataclass(frozen=True, slots=True, kw_only=True)
class BendParams(Group):
    """All parameters of `rectmerge.elastic.unbend.unbend`."""

    faces: FaceParams = field(default_factory=FaceParams)
    fit: FitParams = field(default_factory=FitParams)
    accept: AcceptanceParams = field(default_factory=AcceptanceParams)
