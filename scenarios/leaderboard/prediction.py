"""Prediction of real results by simulation: rankings on both, and success at equal overlap."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.report.reading import TrackResults
from scenarios.report.standings import rate_of
from scenarios.scoring.row import Row
from scenarios.scoring.statistics import Rate

OVERLAPS = (0.15, 0.3, 0.5, 0.7, 1.0001)


def kendall_tau(first: Sequence[float], second: Sequence[float]) -> float:
    """Return Kendall's rank correlation tau-b of two scores of the same items; NaN where all are equal.

    Notes
    -----
    M. G. Kendall, Biometrika 33 (1945), DOI 10.1093/biomet/33.3.239.

    Examples
    --------
    >>> kendall_tau([1, 2, 3], [10, 20, 30]), kendall_tau([1, 2, 3], [3, 2, 1])
    (1.0, -1.0)
    >>> round(kendall_tau([1, 2, 2], [1, 2, 3]), 3)
    0.816
    """
    pairs = list(combinations(zip(first, second, strict=True), 2))
    signs = [((x > y) - (x < y), (u > v) - (u < v)) for (x, u), (y, v) in pairs]
    untied = math.prod(sum(sign[k] != 0 for sign in signs) for k in (0, 1))
    return sum(x * u for x, u in signs) / math.sqrt(untied) if untied else math.nan


def tau_interval(
    simulated: Sequence[TrackResults], real: Sequence[TrackResults], *, resamples: int = 1000, seed: int = 0
) -> tuple[float, float]:
    """Return the 95 % interval of tau-b between the methods' successes, by bootstrap over the places of both sides.

    Parameters
    ----------
    simulated, real
        Tracks whose methods in common are ranked by required pairs right and accepted.
    resamples
        Number of draws of places, with replacement.
    seed
        Of the draws.
    """
    sides = _required(simulated), _required(real)
    labels = [label for label in sides[0] if label in sides[1]]
    signs = []
    for side, rng in zip(sides, np.random.default_rng(seed).spawn(2), strict=True):
        rates = _resampled_rates([side[label] for label in labels], resamples, rng)  # (R, M)
        signs.append(np.sign(rates[:, :, None] - rates[:, None, :]))
    agree = (signs[0] * signs[1]).sum(axis=(1, 2))
    untied = np.sqrt(np.abs(signs[0]).sum(axis=(1, 2)) * np.abs(signs[1]).sum(axis=(1, 2)))
    taus = agree[untied > 0] / untied[untied > 0]
    low, high = np.percentile(taus, [2.5, 97.5]) if len(taus) else (math.nan, math.nan)
    return float(low), float(high)


def _resampled_rates(methods: Sequence[Sequence[Row]], resamples: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return success rates of methods under draws of their places, shape (resamples, methods)."""
    places = {place: k for k, place in enumerate(sorted({row["place"] for rows in methods for row in rows}))}
    hits, counts = np.zeros((2, len(methods), len(places)))
    for number, rows in enumerate(methods):
        for row in rows:
            hits[number, places[row["place"]]] += row["outcome"] == "right-accepted"
            counts[number, places[row["place"]]] += 1
    drawn = rng.multinomial(len(places), np.full(len(places), 1 / len(places)), resamples)
    rates: NDArray[np.float64] = (drawn @ hits.T) / np.maximum(drawn @ counts.T, 1)
    return rates


def successes(tracks: Sequence[TrackResults]) -> dict[str, Rate]:
    """Count, over several tracks, the required pairs of each method that are right and accepted."""
    return {label: rate_of(rows, "right-accepted") for label, rows in _required(tracks).items()}


def matched_overlap(tracks: Sequence[TrackResults]) -> Mapping[str, list[Rate]]:
    """Return each method's successes in bins of true overlap, `OVERLAPS`."""
    return {
        label: [
            rate_of([row for row in rows if (o := row["overlap"]) is not None and low <= o < high], "right-accepted")
            for low, high in pairwise(OVERLAPS)
        ]
        for label, rows in _required(tracks).items()
    }


def _required(tracks: Sequence[TrackResults]) -> dict[str, list[Row]]:
    required: dict[str, list[Row]] = {}
    for track_results in tracks:
        for row in track_results.rows:
            if row["stratum"] == "required":
                required.setdefault(row["method"], []).append(row)
    return required
