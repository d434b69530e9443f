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
    )  # of an answer that counts: on small maps, asked often, the verdict's own threshold is not enough
    growth: float = param(0.2, "share of the free space", HAND)  # that differs before a map is looked at again
    max_move_cells: float = param(2.0, "cells of the reference", HAND)  # within which two answers are the same
    min_share_left: float = param(0.5, "share of the free space", HAND)  # below it a map has begun anew
