"""Whether the best placement can be trusted: its evidence, a probability, and a reason a user can act on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from rectmerge.alignment import Verdict

ACCEPT_AT = 0.65  # probability
AMBIGUOUS_AT = 0.98  # probability that the placement would have without its rival
CRISP_AT = 0.5  # share of matched surface from which two maps fit each other rigidly
SURE_AT = 0.998  # probability from which the mirror image need not be asked: no mirrored pair comes near it
# A logistic model, fitted to 1369 pairs of development maps and simulated or drawn offices, 946 of them unrelated,
# mirrored or wrong.
BIAS, RIVAL, IOU, SUPPORT, MISSING, CONTRADICTION = -3.5, -8.7, 11.3, 10.0, -15.3, -19.4
LARGEST_RIVAL, LARGEST_SUPPORT = 1.5, 1.5
# Whatever else speaks for the best placement, a rival that explains the walls this well leaves it even odds at most.
EQUAL_RIVAL, LEAD = 0.85, 40.0
LARGEST_SLACK_CELLS = 4.0  # a placement that can slide further than this along its walls is even odds at most, too


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """What speaks for a placement.

    Parameters
    ----------
    likelihood
        Log-likelihood ratio of all walls against chance.
    rival
        The best distinct placement's likelihood over this one's: below 1 for the best, and the smaller the better.
    decoy
        The likelihood of the best placement of the mirror image over this one's. No placement of a mirror image can be
        right, so it shows what chance achieves on maps like these. 0 where it was not asked.
    overlap, iou
        Of the free space of the working grids: over the smaller area, and over the union.
    support
        Likelihood per wall point of the map that has fewer.
    missing
        Share of the walls on known cells of the other map that lie deep in its free space.
    matched
        Share of the wall surface in the overlap that lies within 2.5 cells of the other map's.
    conflict
        As in `rectmerge.overlap.Agreement`.
    slack_cells
        Standard deviation of the placement in its least certain direction, in cells of the map that stays.
    is_at_limit
        Whether the scale ended at the limit of what was allowed: the maps would fit better beyond it.
    """

    likelihood: float
    rival: float
    overlap: float
    iou: float
    support: float
    missing: float
    matched: float = 0.0
    conflict: float = 0.0
    slack_cells: float = 0.0
    decoy: float = 0.0
    is_at_limit: bool = False

    @property
    def probability(self) -> float:
        """Probability that the placement is right."""
        return self._probability(self.rival, self.decoy)

    @property
    def probability_without_rival(self) -> float:
        """The same if no other placement came close."""
        return self._probability(0.0, 0.0)

    @property
    def is_slack(self) -> bool:
        """Whether the walls in common leave the placement free to slide or turn."""
        return self.slack_cells > LARGEST_SLACK_CELLS

    def _probability(self, rival: float, decoy: float) -> float:
        # maps that fit to the cell in places are not bent: where they disagree, something is wrong
        contradiction = self.conflict * min(1.0, self.matched / CRISP_AT)
        z = (
            BIAS
            + RIVAL * min(max(rival, decoy), LARGEST_RIVAL)
            + IOU * math.sqrt(self.iou)
            + SUPPORT * math.sqrt(min(max(self.support, 0.0), LARGEST_SUPPORT))
            + MISSING * self.missing
            + CONTRADICTION * contradiction
        )
        z = min(z, LEAD * (EQUAL_RIVAL - rival))
        z = min(z, 0.0) if self.is_slack or self.is_at_limit else z
        return 1 / (1 + math.exp(-max(-30.0, min(30.0, z))))


def likelihood_ratio(other: float, own: float) -> float:
    """Log-likelihood of another placement over one's own: 0 at the least, and 2 where one's own is hardly positive."""
    other = max(0.0, other)
    return other / own if own > other / 2 else 2.0


def judge(evidence: Evidence) -> tuple[Verdict, str]:
    """Give the verdict on the best placement and its reason."""
    if evidence.probability >= ACCEPT_AT:
        return "accepted", f"the walls of both maps agree over {evidence.overlap:.0%} of the smaller free area"
    if replace(evidence, is_at_limit=False).probability >= ACCEPT_AT:
        return "rejected", (
            "the maps fit best at a scale beyond the bounds of the search: widen --scale, or check the resolutions"
        )
    if replace(evidence, slack_cells=0.0).probability >= ACCEPT_AT:
        return "rejected", (
            f"the walls in common do not hold the placement: it can slide by {evidence.slack_cells:.0f} cells; map a "
            "corner or a crossing wall that both maps share"
        )
    if evidence.probability_without_rival >= AMBIGUOUS_AT:
        return "ambiguous", (
            f"more than one placement explains the walls (the second has {evidence.rival:.0%} of the evidence of the "
            "first): look at the candidates, or map more of what tells the places apart"
        )
    if evidence.likelihood <= 0:
        return "rejected", "no placement explains the walls better than chance: are these maps of the same place?"
    return "rejected", (
        f"the best placement agrees too little (overlap {evidence.overlap:.0%} of the smaller map, "
        f"{evidence.missing:.0%} of its walls contradicted): the maps share too little, or nothing"
    )
