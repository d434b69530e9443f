"""Parameters of the joint alignment of many maps: every number that shapes an answer, with its unit and its source."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from rectmerge.declaration import HAND, Group, param

TRIED = "tried on 36 hand-held maps of four buildings, whose answers they separate from wrong ones"
WALLS = "right placements of simulated pairs had 0 to 12, 95 of 100 wrong ones -7 to -16"
LEADS = "85 ambiguous pairs of ten simulated hospitals: right with odds that fall by 50 nats per share on the floor"
WARDS = "ten simulated hospitals: right arrangements lead by 2 to 18 nats, wrong ones by 0.5 and 6, these by few nats"
ROWS = "tried on simulated hospitals, whose rooms repeat"


@dataclass(frozen=True, slots=True, kw_only=True)
class PartnerParams(Group):
    """Ranking of partners by neighbouring rectangles, and the pairs that are asked."""

    neighbours: int = param(10, "rectangles", HAND)  # of a rectangle, the nearest ones
    reach_sizes: float = param(4.0, "sizes of the rectangle", HAND)  # no neighbour further away
    size_step: float = param(0.15, "log", HAND)  # of a word's ratio of sizes; aspects have twice this step
    offset_step: float = param(0.25, "sizes of the rectangle", HAND)  # of a word's offset
    border_words: int = param(2, "words", HAND)  # beside the nearest one, where a measure lies near a border
    border_weight: float = param(0.5, "share", HAND)  # of those
    max_document_share: float = param(0.7, "share of the maps", HAND)  # that have a word, or it says nothing
    partners: int = param(4, "maps", "4 each kept the maps of four buildings connected")  # asked of each map
    pairs_per_map: int = param(
        5, "pairs", "hand, no data; trades time for recall"
    )  # up to which maps left alone are asked for


@dataclass(frozen=True, slots=True, kw_only=True)
class EvidenceParams(Group):
    """Log-odds of a pair's candidates, and agreement with a joint placement."""

    max_log_odds: float = param(6.0, "nats", TRIED)  # of a pair's best candidate: beyond, no judge is calibrated
    min_log_odds: float = param(-30.0, "nats", "stands for none", least=-math.inf)
    bonus: float = param(3.0, "nats", TRIED)  # of the second agreement: by chance it is rare
    bonus_overlaps: tuple[float, ...] = param(
        (0.08, 0.2), "share", "as miss_overlaps: in a sliver of two maps walls agree by chance", length=2
    )  # between which the bonus grows from nothing
    tolerance: float = param(0.02, "share of the smaller map's diagonal", TRIED)  # standard deviation of an agreement
    max_sigmas: float = param(2.5, "standard deviations", TRIED)  # of an agreement
    min_agreement: float = param(-8.0, "nats", TRIED, least=-math.inf)  # below it a candidate does not agree
    max_slack_cells: float = param(4.0, "map cells", "as robust.verdict.max_slack_cells")
    miss_overlaps: tuple[float, ...] = param((0.08, 0.2, 0.4, 0.7), "share", TRIED, length=4)
    miss_nats: tuple[float, ...] = param((0.0, -0.7, -2.5, -4.0), "nats", TRIED, least=-math.inf, length=4)
    max_contradiction: float = param(-12.0, "nats", WALLS, least=-math.inf)  # of a placement, by the walls of one pair
    repeated_log_odds: float = param(2.2, "nats", ROWS)  # of two candidates: the place repeats itself
    fit_weight: float = param(2.0, "nats per nat", ROWS)  # of how much worse than the best a repeated one fits
    even_lead: float = param(1.0, "nats", LEADS)  # of the best of the repeated ones over the next, for even odds
    lead_weight: float = param(3.0, "nats per nat", LEADS)  # of a lead beyond
    floor_cost: float = param(50.0, "nats per share", LEADS)  # of walls of the best on solid floor
    max_lead: float = param(3.0, "nats", HAND)  # that the lead adds or takes
    little_overlap: float = param(0.1, "share", ROWS)  # of a repeated one
    little_overlap_cost: float = param(9.0, "nats", ROWS)


@dataclass(frozen=True, slots=True, kw_only=True)
class JoinParams(Group):
    """Joins of components, best first."""

    accept_at: float = param(0.85, "probability", "as robust.verdict.accept_at")
    trial_log_odds: float = param(0.5, "nats", ROWS)  # of a join on trial, which the whole component has to confirm
    move_margin: float = param(1.0, "nats", HAND)  # by which a part of a component must fit better in another
    min_proposal: float = param(-4.0, "nats", TRIED, least=-math.inf)  # of a candidate that proposes a join
    max_proposals: int = param(25, "placements", "hand, no data; trades time for exactness")
    needs: float = param(1.5, "nats", TRIED)  # of one pair by itself: a join of mere hints is none
    implied_overlap: float = param(0.2, "share", TRIED)  # of a pair that a join lays on each other: it is asked
    few_agreeing: int = param(1, "pairs", HAND)  # on which a join rests, for the walls of all its pairs to be asked
    asked_at_once: int = param(3, "pairs", HAND)
    enough_agreeing: int = param(3, "pairs", TRIED)  # that agree, for a single map to be joined without asking more

    change_margin: float = param(3.0, "nats", HAND)  # by which new placements must be better than earlier ones

    @property
    def accept_log_odds(self) -> float:
        """Log-odds from which a join is accepted."""
        return math.log(self.accept_at / (1 - self.accept_at))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceParams(Group):
    """Reweighted least squares of a component's placements."""

    sigmas: float = param(2.0, "standard deviations", "2 and 3 alike, 1 worse, on 23 simulated fleets and real maps")
    sigma: float = param(0.01, "share of the smaller map's diagonal", TRIED)  # and at most this: half the say is lost
    start_sigma: float = param(0.05, "share of the smaller map's diagonal", "all that agrees")  # halved each time
    min_sigma: float = param(0.0005, "share of the smaller map's diagonal", HAND)
    min_overlap: float = param(0.02, "share", HAND)  # a pair counts by its overlap, and by this at least
    passes: int = param(3, "passes", HAND)  # of placement and agreement
    iterations: int = param(10, "iterations", HAND)  # of each pass
    settled_cells: float = param(0.01, "cells", HAND)  # of the reference, by which nothing moves any more


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrangeParams(Group):
    """Arrangement of components that no join decides."""

    beam: int = param(8, "arrangements", "hand, no data; trades time for exactness")  # of each number of components
    most_maps: int = param(12, "maps", "hand, no data; trades recall for time")  # of the components arranged together
    margin: float = param(2.0, "nats", WARDS)  # by which the best leads, beside the odds of a join


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetParams(Group):
    """Parameters of the joint alignment, by stage."""

    partner: PartnerParams = dataclasses.field(default_factory=PartnerParams)
    evidence: EvidenceParams = dataclasses.field(default_factory=EvidenceParams)
    join: JoinParams = dataclasses.field(default_factory=JoinParams)
    place: PlaceParams = dataclasses.field(default_factory=PlaceParams)
    arrange: ArrangeParams = dataclasses.field(default_factory=ArrangeParams)
