"""Parameters of the live merger, each with its unit and its source."""

from __future__ import annotations

from dataclasses import dataclass

from rectmerge.declaration import HAND, Group, param


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveParams(Group):
    """Rules by which the live merger believes, keeps and drops a placement."""

    accepts: int = param(2, "answers", "a question asked at every update multiplies false accepts")  # that must agree
    least_confidence: float = param(
        0.95, "probability", "wrong first answers of 46 missions of trust, seed 5, had 0.90 to 0.93"
    )  # of an answer that counts; see `confidence_asked` for the one that publishes
    growth: float = param(0.2, "share of the free space", HAND)  # that differs before a map is looked at again
    max_move_cells: float = param(2.0, "cells of the reference", HAND)  # within which two answers are the same
    min_share_left: float = param(0.5, "share of the free space", HAND)  # below it a map has begun anew

    def confidence_asked(self, question: int) -> float:
        """Return the confidence asked of the answer that publishes a placement, for the nth question about it.

        Notes
        -----
        Each question is another chance of a wrong yes. The risk that `least_confidence` leaves is shared among all of
        them: 1 / (n (n + 1)) of it falls to the nth, and however many follow, the shares add up to the whole
        (Bonferroni's bound with a sum that never ends). Walls that fit by right add to the confidence with every
        version; those of a twin do not.

        Examples
        --------
        >>> [round(LiveParams().confidence_asked(n), 4) for n in (1, 2, 5, 10)]
        [0.975, 0.9917, 0.9983, 0.9995]
        """
        return 1.0 - (1.0 - self.least_confidence) / (question * (question + 1))
