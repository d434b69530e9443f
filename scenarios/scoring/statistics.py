"""Rates with their counts, and intervals by bootstrap clustered by place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError

RESAMPLES = 2000
DRAWN_AT_ONCE = 10**6  # numbers of places in one step of the bootstrap
Z95 = 1.959963984540054  # two-sided 95 % of the normal distribution


@dataclass(frozen=True, slots=True)
class Rate:
    """A rate as a count, with its 95 % interval; of an empty sample 0 of 0, anywhere in 0..1.

    Parameters
    ----------
    k, n
        How many of how many.
    low, high
        The interval of the rate, 0..1.
    """

    k: int
    n: int
    low: float
    high: float

    @property
    def value(self) -> float | None:
        """The rate, 0..1; None of an empty sample."""
        return self.k / self.n if self.n else None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {**asdict(self), "rate": self.value}

    def __str__(self) -> str:
        if not self.n:
            return "0 of 0"
        return f"{self.k} of {self.n} ({100 * self.k / self.n:.0f} %, {100 * self.low:.0f}-{100 * self.high:.0f})"


def wilson_interval(rate: float, n: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a rate seen in `n` independent trials.

    Notes
    -----
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927), DOI 10.1080/01621459.1927.10502953.

    Examples
    --------
    >>> low, high = wilson_interval(0.0, 50)
    >>> low, round(high, 4)
    (0.0, 0.0713)
    """
    if n == 0:
        return 0.0, 1.0
    weight = Z95**2 / n
    centre = (rate + weight / 2) / (1 + weight)
    reach = Z95 / (1 + weight) * math.sqrt(rate * (1 - rate) / n + Z95**2 / (4 * n * n))
    low = 0.0 if rate == 0 else max(0.0, centre - reach)
    return low, 1.0 if rate == 1 else min(1.0, centre + reach)


def clustered_rate(hits: Sequence[bool], places: Sequence[str], *, seed: int = 0) -> Rate:
    """Count hits and give the rate's interval by bootstrap over places.

    Parameters
    ----------
    hits
        One per row.
    places
        The place (cluster) of each row; rows of one place are not independent.
    seed
        Of the resampling.

    Raises
    ------
    InputError
        If the two do not have the same length.

    Notes
    -----
    Where the bootstrap says nothing, because every place has the same rate or there is one place only, the interval
    is Wilson's with the number of places as the number of trials.

    Examples
    --------
    >>> str(clustered_rate([True, True, False, True], ["a", "a", "b", "c"]))
    '3 of 4 (75 %, 0-100)'
    """
    if len(hits) != len(places):
        raise InputError(f"one place per row: {len(hits)} rows, {len(places)} places")
    return rate_of_places(*_by_place(np.asarray(hits, dtype=np.float64), places), seed=seed)


def clustered_difference(
    now: Sequence[float], before: Sequence[float], places: Sequence[str], *, seed: int = 0
) -> tuple[float, float, float]:
    """Return the mean difference of paired rows, now less before, with its 95 % interval by bootstrap over places.

    Parameters
    ----------
    now, before
        One value per row each: of the same pair under the two runs.
    places
        The place (cluster) of each row.
    seed
        Of the resampling.

    Notes
    -----
    Where every place has the same mean difference the bootstrap says nothing, and the interval is that one number.

    Examples
    --------
    >>> clustered_difference([1, 1], [0, 1], ["a", "a"])
    (0.5, 0.5, 0.5)
    """
    if not len(now) == len(before) == len(places):
        raise InputError(f"one value per row: {len(now)} now, {len(before)} before, {len(places)} places")
    if not places:
        return 0.0, 0.0, 0.0
    sums, counts = _by_place(np.asarray(now, dtype=np.float64) - np.asarray(before, dtype=np.float64), places)
    return float(sums.sum() / len(places)), *_bootstrap(sums, counts, seed)


def rate_of_places(sums: NDArray[np.float64], counts: NDArray[np.float64], *, seed: int = 0) -> Rate:
    """Return the rate of hits counted by place, as `clustered_rate`; hits and rows of each place, shape (places,)."""
    if not len(sums):
        return Rate(0, 0, 0.0, 1.0)
    k, n = int(sums.sum()), int(counts.sum())
    if np.ptp(sums / counts) == 0:
        return Rate(k, n, *wilson_interval(k / n, len(sums)))
    return Rate(k, n, *_bootstrap(sums, counts, seed))


def mean_of_places(sums: NDArray[np.float64], counts: NDArray[np.float64]) -> float:
    """Return the mean of the places' rates, every place weighing the same; hits and rows of each, at least one.

    Examples
    --------
    >>> mean_of_places(np.array([3.0, 0.0]), np.array([3.0, 1.0]))
    0.5
    """
    return float((sums / counts).mean())


def _bootstrap(sums: NDArray[np.float64], counts: NDArray[np.float64], seed: int) -> tuple[float, float]:
    """Return the 95 % interval of sums over counts, places drawn with replacement; a few resamples at a time."""
    rng, rates = np.random.default_rng(seed), np.empty(RESAMPLES)
    step = max(1, DRAWN_AT_ONCE // len(sums))
    for start in range(0, RESAMPLES, step):
        part = rates[start : start + step]
        drawn = rng.integers(0, len(sums), (len(part), len(sums)))  # (R, places)
        part[:] = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.quantile(rates, (0.025, 0.975))
    return float(low), float(high)


def _by_place(values: NDArray[np.float64], places: Sequence[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    _, index = np.unique(np.asarray(places), return_inverse=True)
    sums: NDArray[np.float64] = np.bincount(index, weights=values).astype(np.float64)
    counts: NDArray[np.float64] = np.bincount(index).astype(np.float64)
    return sums, counts
