"""Parameters of the method `robust`: every number that shapes an answer, by stage, with its unit and its source.

`--set robust.GROUP.FIELD=VALUE` changes one. A source is a calibration command with its commit, a row of the ablation
in results/robust/README.md, an argument, or "hand, no data". Lengths in cells are cells of the working grid unless the
unit says otherwise.

Compiled loops keep five numbers of their own, by hand and without data: `MAX_STEP` and `MIN_FACING_COS` of
`rectmerge._kernels.fitting`, `SIDE_ERROR_CELLS` and `MIN_SIDE_VARIANCE` of `rectmerge._kernels.placements`, and
`ROUNDING` of `rectmerge._kernels.bounding`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from rectmerge.declaration import CALIBRATED, HAND, LAYOUT, Group, ablation, param
from rectmerge.errors import InputError
from rectmerge.robust.correlation_params import AllRoundParams, CorrelateParams
from rectmerge.robust.detail_params import ContradictParams, DetailParams

HELD_BACK_GAIN = (
    "real places, held out: of withheld best candidates of 0.1 to 0.85 unbending holds for 7 of 26 right and 0 of 43 "
    "wrong ones; with 3 of 43, the 95 % bound, 1.3, rounded down"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PrepareParams(Group):
    """Working grid, directions and rectangles of one map."""

    diagonal_cells: float = param(400.0, "cells", HAND, most=4000)  # of the working grid
    max_diagonal_cells: float = param(1000.0, "cells", HAND, most=4000)  # the same of a map with narrow passages
    mean_clearance_cells: float = param(6.0, "cells", HAND)  # of free cells, or the grid is finer
    margin_cells: int = param(4, "cells", HAND, most=1000)  # around the working grid
    free_share: float = param(0.3, "share of a cell's area", HAND)  # seen free that makes a working cell free
    free_neighbours_share: float = param(0.45, "share of 3 x 3 cells", HAND)  # free that fills a hole between rays
    max_speck_cells: int = param(4, "map cells", ablation("removal of specks"), least=0)  # of a lone obstacle
    max_speck_weight: int = param(4, "map cells", ablation("removal of specks"), least=0)  # of a lone working cell
    speck_factor: float = param(2.0, "map cells", HAND, least=0.1)  # along a working cell; beyond it that weight grows
    max_directions: int = param(4, "directions", HAND, most=90)  # in which walls pile up
    min_direction_share: float = param(0.1, "share of the first contrast", HAND)  # of a further direction
    strong_share: float = param(0.5, "share of the first contrast", HAND)  # of a second direction as good as the first
    max_projected_points: int = param(1500, "wall points", LAYOUT)  # evenly spaced, in the first pass
    coarse_bin_cells: float = param(1.5, "cells", HAND, least=0.01)  # of the projection profile, steps of 1 degree
    fine_bin_cells: float = param(1.0, "cells", HAND, least=0.01)
    fine_steps_deg: tuple[float, ...] = param((0.25, 0.06), "degrees", HAND)
    fine_reach_steps: int = param(5, "steps", HAND, most=1000)  # of each size, to each side
    direction_width_deg: int = param(10, "degrees", HAND)  # no second direction closer to a first
    max_rectangles: int = param(120, "rectangles", HAND, most=10_000)  # kept of each map and direction
    min_side_cells: int = param(4, "cells", HAND)  # of a rectangle
    full_side_cells: float = param(8.0, "cells", HAND)  # narrower rectangles rank lower
    unsupported_worth: float = param(0.2, "share", HAND)  # of a rectangle without a wall along its sides
    max_iou: float = param(0.7, "share", HAND)  # of two kept rectangles
    min_wall_share: float = param(0.4, "share of a side", HAND)  # along a wall, for the side to be a wall


@dataclass(frozen=True, slots=True, kw_only=True)
class FaceParams(Group):
    """Faces of walls by outward normal."""

    free_at_cells: tuple[float, ...] = param((2.0, 3.0), "cells", HAND)  # in front of a face
    min_run_cells: float = param(25.0, "cells", ablation("walls apart from things"), least=0)  # or clutter
    run_width_cells: float = param(3.0, "cells", HAND)  # sideways spread of a run
    run_gap_cells: float = param(4.0, "cells", HAND)  # interruption of a run


@dataclass(frozen=True, slots=True, kw_only=True)
class GainParams(Group):
    """Log-likelihood ratio of one wall point."""

    max_nats: float = param(3.0, "nats", HAND)
    near_sigmas: float = param(2.5, "standard deviations", HAND)  # unknown cells this close to a wall count as known


@dataclass(frozen=True, slots=True, kw_only=True)
class ProposeParams(Group):
    """Hypotheses by pairs of rectangles, and their screening."""

    use_two_sided: bool = param(True, "switch", ablation("rectangle pairs that agree in both sides"))
    use_correlation: bool = param(True, "switch", ablation("every shift, where rectangles do not convince"))
    use_rivals: bool = param(True, "switch", ablation("rivals at the same scale"))
    aspect_tolerances: tuple[float, ...] = param((0.05, 0.1, 0.2, 0.4), "log aspect", HAND)  # wider where few agree
    enough_hypotheses: int = param(3000, "hypotheses", LAYOUT)  # to stop widening the tolerance
    plenty_hypotheses: int = param(8000, "hypotheses", LAYOUT)  # to do without pairs that agree in one extent only
    max_hypotheses: int = param(400_000, "hypotheses", LAYOUT, most=10_000_000)
    max_one_sided_pairs: int = param(40_000, "rectangle pairs", LAYOUT)  # compared in one extent
    min_one_sided: int = param(10, "rectangles", HAND)  # of each frame, compared in one extent
    scale_slack: float = param(0.03, "log scale", HAND)  # of hypotheses beyond the bounds; refinement comes back
    noise_spreads_cells: tuple[float, ...] = param((1.5, 3.75), "cells", HAND)  # of walls about their partners
    noise_outliers: float = param(0.25, "share", HAND)  # of walls that the other map lacks
    screen_points: tuple[int, ...] = param((40, 200), "wall points", LAYOUT, length=2)  # in the two screenings
    max_screened: int = param(1000, "hypotheses", LAYOUT)  # kept by the first screening
    max_refined: int = param(60, "hypotheses", LAYOUT, most=100_000)
    max_fits: int = param(15, "placements", LAYOUT, most=100_000)  # refined ones that are ranked
    refine_points: int = param(300, "wall points", LAYOUT)  # of each map
    coarse_reaches_cells: tuple[float, ...] = param((16.0, 12.0, 8.0, 8.0), "cells", HAND)
    fine_reaches_cells: tuple[float, ...] = param((6.0, 6.0, 4.0, 4.0, 3.0, 3.0), "cells", HAND)
    same_hypothesis_cells: float = param(4.0, "cells", HAND)  # hypotheses closer than this are one
    same_fit_cells: float = param(3.0, "cells", HAND)  # refined ones
    weak_contrast: float = param(0.6, "contrast", HAND)  # below it, frames all round are tried
    all_round_step_deg: int = param(5, "degrees", LAYOUT)


@dataclass(frozen=True, slots=True, kw_only=True)
class RankParams(Group):
    """Likelihood and agreement of placements, and which of them are the same."""

    rigid_reaches_cells: tuple[float, ...] = param((2.0, 2.0, 2.0), "cells", HAND)
    bent_reaches_cells: tuple[float, ...] = param(
        (10.0,) * 8, "cells", "hand: with three steps and 800 points, 4 of 96 pairs of real_maps hung on the seed"
    )
    refine_points: int = param(3000, "wall points", LAYOUT)  # of each map
    spreads_cells: tuple[float, ...] = param((1.0, 2.0, 4.0), "cells", HAND, length=3)  # rigid, drifting, bent
    outliers: tuple[float, ...] = param((0.05, 0.15, 0.25), "share", HAND, length=3)  # of the same
    rigid_damping: float = param(0.25, "power of the overlap", HAND)  # of the first likelihood
    loose_damping: float = param(0.5, "power of the overlap", HAND)  # of the others
    max_bent_fits: int = param(8, "placements", LAYOUT)  # scored block by block
    bending_spread_cells: float = param(1.5, "cells", HAND)
    bending_outliers: float = param(0.2, "share", HAND)
    block_cells: float = param(40.0, "cells", HAND)  # of the blocks that shift by themselves
    bend_cells: int = param(8, "cells", HAND, most=200)  # how far a block may shift
    bend_step_cells: int = param(2, "cells", LAYOUT)
    bend_cost: float = param(0.01, "nats per wall point and squared cell", HAND)
    block_cost: float = param(6.0, "nats", "hand: the two coordinates of a block that shifts are fitted, not known")
    matched_cells: float = param(1.5, "cells", HAND)  # edges of bins of the distance between faces
    near_cells: float = param(4.0, "cells", HAND)
    contradicted_cells: float = param(8.0, "cells", HAND)
    known_beside_cells: float = param(3.0, "cells", HAND)  # unknown cells this close to a wall count as known
    max_free_samples: int = param(2000, "free cells", LAYOUT)  # on which overlaps are estimated
    same_fit_cells: float = param(3.0, "cells", HAND)  # placements closer than this say the same
    same_radius_share: float = param(0.2, "share of A's radius", HAND)  # or than this
    same_log_odds: float = param(6.0, "log-odds", HAND)  # within which the likelier placement replaces its head
    max_ranked: int = param(20, "placements", HAND, most=100_000)  # kept

    def __post_init__(self) -> None:
        Group.__post_init__(self)
        distances = self.matched_cells, self.near_cells, self.contradicted_cells
        if not distances[0] < distances[1] < distances[2]:
            raise InputError(f"matched_cells < near_cells < contradicted_cells must hold, got {distances}")


@dataclass(frozen=True, slots=True, kw_only=True)
class ConfidenceParams(Group):
    """Models of the plausibility of a placement, of rigid and of bent maps."""

    use_rigid: bool = param(True, "switch", ablation("the model of rigid maps"))
    use_bent: bool = param(True, "switch", ablation("the model of bent maps"))
    rigid: tuple[float, ...] = param(
        (-3.92, 0.93, 0.0, -11.25, 2.18, -4.45, 2.87, -16.12, -31.43, -3.01, -3.71),
        "log-odds per term",
        CALIBRATED,
        least=-math.inf,
        length=11,
    )
    bent: tuple[float, ...] = param(
        (-3.45, 13.54, 2.2, -23.8, -1.77, 1.02, -16.48), "log-odds per term", CALIBRATED, least=-math.inf, length=7
    )
    min_overlap: float = param(0.03, "share", HAND)  # added before the logarithm
    min_matched_faces: float = param(20.0, "faces", HAND)  # added before the logarithm
    max_support: float = param(1.5, "nats per wall point", HAND)
    min_support: float = param(0.05, "nats per wall point", HAND)  # added before the logarithm
    fat_wall_cells: float = param(2.8, "map cells", HAND)  # maps with thinner walls are less likely bent
    thin_wall_cost: float = param(5.0, "log-odds per log thickness", HAND, least=0)
    bent_surface_matched: float = param(0.35, "share", HAND)  # of the surface of bent maps that meets all the same
    absent_log_odds: float = param(-30.0, "log-odds", "stands for none", least=-math.inf)  # of a model that is off


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactParams(Group):
    """Refinement on the cells of the given maps."""

    use_fit: bool = param(True, "switch", ablation("fit of the surfaces"))
    scale_slack: float = param(0.05, "share", HAND)  # by which refinement may leave the bounds of the scale
    at_limit: float = param(1e-4, "share", HAND)  # a scale this close to a widened bound was stopped there
    reaches_cells: tuple[float, ...] = param(
        (6.0, 4.0, 3.0, 2.5, 2.5, 2.0, 2.0, 2.0, 2.0), "map cells", "hand: converges on 35 rigid pairs of standard"
    )
    strides: tuple[int, ...] = param(
        (4, 4, 2, 1, 1, 1, 1, 1, 1), "surface points", LAYOUT
    )  # of those used at each reach
    surface_points: int = param(6000, "surface points", LAYOUT)  # of each map, for the best placement
    rival_points: int = param(300, "surface points", LAYOUT)  # for the others
    looked_at: int = param(8, "times the surface points", LAYOUT)  # asked whether they lie inside the other map
    min_matched_share: float = param(
        0.5, "share of the surface on known cells", HAND
    )  # with a partner, or the placement stays
    correlated_cells: float = param(
        32.0,
        "surface cells",
        "93 % of 82 rigid training pairs of noise 1 (trust, standard) lie in the 90 % ellipse; 84 % with 17 of noise 2",
    )  # that err together and count as one
    unsure: tuple[float, ...] = param((1.0, 1.0, 1e4, 1e4), "radians, log scale, cells", "no knowledge", length=4)

    def __post_init__(self) -> None:
        Group.__post_init__(self)
        if len(self.strides) != len(self.reaches_cells):
            raise InputError(f"strides must be {len(self.reaches_cells)} values as reaches_cells, got {self.strides}")

    def widened(self, bounds: tuple[float, float]) -> tuple[float, float]:
        """Return the bounds of a scale with the slack that refinement has."""
        return bounds[0] * (1 - self.scale_slack), bounds[1] * (1 + self.scale_slack)


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictParams(Group):
    """Thresholds of the verdict."""

    accept_at: float = param(0.85, "probability", HAND)
    likely_at: float = param(0.5, "probability", HAND)  # below `accept_at`, and a placement is ambiguous all the same
    ambiguous_at: float = param(0.9, "probability", HAND)  # by the placement's own log-odds, whatever its rivals
    weights: tuple[float, ...] = param(
        (0.31, 0.57, 0.65), "log-odds: constant, per own, per lead", CALIBRATED, least=-math.inf, length=3
    )
    chance_log_odds: float = param(-3.0, "log-odds", HAND, least=-math.inf)  # that chance reaches even without rivals
    bend_log_odds: float = param(1.0, "log-odds", HELD_BACK_GAIN, least=0)  # that unbending adds; 0: it is not tried
    sure_at: float = param(0.995, "probability", ablation("the mirror image as a rival"), least=0)  # no mirror needed
    max_slack_cells: float = param(5.0, "map cells", HAND)  # a placement that slides further is even odds at most
    mirrored_by: float = param(3.0, "log-odds", HAND)  # by which the mirror image fits better in mirrored maps
    least_overlap: float = param(0.14, "share of the smaller free area", "hand: no related pair of the fit has less")
    accept_little_at: float = param(0.95, "probability", HAND)  # asked below that overlap

    def asked_of(self, overlap: float) -> float:
        """Return the probability from which a placement is accepted, by its overlap."""
        return self.accept_at if overlap >= self.least_overlap else self.accept_little_at


@dataclass(frozen=True, slots=True, kw_only=True)
class ReasonParams(Group):
    """Thresholds of the reasons that go with a verdict; they change no verdict."""

    min_free_cells: int = param(1500, "cells", HAND)  # less shows no room
    max_roughness: float = param(0.25, "share of neighbours that differ", "hand: crowded maps have 0.1, noise 0.5")
    bent_share: float = param(0.12, "share of the walls", HAND)  # near each other but not matched in bent maps
    bent_support: float = param(0.25, "nats per wall point", HAND)  # of bent maps that fit each other
    contradicted_share: float = param(0.4, "share of the walls", "hand: more in 10 of 36 refused pairs of two places")
    little_overlap: float = param(0.35, "share", HAND)  # under which walls match by chance
    far_behind: float = param(3.0, "times the odds of the rest", HAND)  # from which only the best deserves a look


@dataclass(frozen=True, slots=True, kw_only=True)
class HintParams(Group):
    """Search around a hint."""

    guess_std: float = param(0.25, "share of B's radius", HAND)
    guess_shifts: tuple[float, ...] = param((-0.3, 0.0, 0.3), "share of B's radius", HAND, least=-math.inf)
    guess_turns_deg: tuple[float, ...] = param((-10.0, -5.0, 0.0, 5.0, 10.0), "degrees", HAND, least=-math.inf)
    by_hand_share: float = param(0.1, "share of B's radius", HAND)  # within which a placement is the one by hand
    by_hand_cells: float = param(3.0, "cells", HAND)  # at least
    better_by: float = param(1.0, "log-odds", HAND)  # by which a placement elsewhere is better


@dataclass(frozen=True, slots=True, kw_only=True)
class CertificateParams(Group):
    """Branch and bound around an accepted placement."""

    margin: float = param(0.1, "share of the score", HAND)  # below it, a score comes close
    away_share: float = param(0.05, "share of A's extent", HAND)  # beyond which a placement is another one
    batch_boxes: int = param(8192, "boxes", LAYOUT, most=1_000_000)  # split at a time
    max_open_boxes: int = param(400_000, "boxes", LAYOUT, most=10_000_000)  # before the newest go first
    max_tried_cells: float = param(8.0, "cells", LAYOUT)  # of boxes whose middle may be a counter-example
    faces: int = param(240, "faces", LAYOUT, most=10_000)  # of both maps, about
    group_faces: int = param(32, "faces", LAYOUT)  # that share a bound, at most
    outliers: float = param(0.05, "share", HAND)


@dataclass(frozen=True, slots=True, kw_only=True)
class OutsideParams(Group):
    """Pictures of a map that are white around the building."""

    min_known_share: float = param(0.95, "share", HAND)  # of the convex hull of what is known: robots leave gaps
    min_free_edge: float = param(0.9, "share", HAND)  # of the edge of that hull
    edge_cells: tuple[float, ...] = param((2.0, 4.0), "cells", HAND, length=2)  # of the edge; turned ones are ragged
    gap_share: float = param(0.035, "share", HAND)  # half of the widest gap that is closed, of the root of the area
    min_inside_share: float = param(0.12, "share", HAND)  # of the free cells; what is less was a hall


@dataclass(frozen=True, slots=True, kw_only=True)
class Params(Group):
    """Parameters of the method: the stages in order, and the number of candidates reported."""

    outside: OutsideParams = dataclasses.field(default_factory=OutsideParams)
    prepare: PrepareParams = dataclasses.field(default_factory=PrepareParams)
    faces: FaceParams = dataclasses.field(default_factory=FaceParams)
    gain: GainParams = dataclasses.field(default_factory=GainParams)
    propose: ProposeParams = dataclasses.field(default_factory=ProposeParams)
    correlate: CorrelateParams = dataclasses.field(default_factory=CorrelateParams)
    all_round: AllRoundParams = dataclasses.field(default_factory=AllRoundParams)
    rank: RankParams = dataclasses.field(default_factory=RankParams)
    detail: DetailParams = dataclasses.field(default_factory=DetailParams)
    contradict: ContradictParams = dataclasses.field(default_factory=ContradictParams)
    confidence: ConfidenceParams = dataclasses.field(default_factory=ConfidenceParams)
    exact: ExactParams = dataclasses.field(default_factory=ExactParams)
    verdict: VerdictParams = dataclasses.field(default_factory=VerdictParams)
    reason: ReasonParams = dataclasses.field(default_factory=ReasonParams)
    hint: HintParams = dataclasses.field(default_factory=HintParams)
    certificate: CertificateParams = dataclasses.field(default_factory=CertificateParams)
    max_candidates: int = param(5, "candidates", HAND)  # reported
