"""Slow oracle: what the compiled loop of the stochastic search has to agree with, written to be read."""

from __future__ import annotations

import math

from rectmerge.similarity import Similarity


def dissimilarity(at, cells, maps, middle, lock) -> float:
    """Sum, both ways and over both values, the mean distance less `lock` times the mean agreement of placed cells."""
    turn = Similarity(math.exp(at[1]), float(at[0]))
    du, dv = turn.apply(middle)
    placement = Similarity(turn.scale, turn.angle, at[2] - du, at[3] - dv)
    total = 0.0
    for points, target, move, unit in (
        (cells[1], maps[0], placement, 1.0),
        (cells[0], maps[1], placement.inverse(), placement.scale),
    ):
        for value in range(2):
            for u, v in move.apply(points[value]):
                row, col = min(max(v, 0), target[0].shape[0] - 1), min(max(u, 0), target[0].shape[1] - 1)
                beyond = abs(v - row) + abs(u - col)
                same, other = (target[k][math.floor(row + 0.5), math.floor(col + 0.5)] for k in (value, 1 - value))
                is_seen = beyond < 0.5
                agreement = is_seen * (1 if same == 0 else -1 if other == 0 else 0)
                total += (unit * (same + beyond) - lock * agreement) / len(points[value])
    return float(total)
