"""Rates with their counts, intervals by bootstrap clustered by place, and the summary of a run's rows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from scenarios.score import RIGHT

STRATA = ("required", "optional", "unrelated")
RESAMPLES = 2000
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
    if not hits:
        return Rate(0, 0, 0.0, 1.0)
    sums, counts = _by_place(np.asarray(hits, dtype=np.float64), places)
    k, n = int(sums.sum()), len(hits)
    if np.ptp(sums / counts) == 0:
        return Rate(k, n, *wilson_interval(k / n, len(sums)))
    drawn = np.random.default_rng(seed).integers(0, len(sums), (RESAMPLES, len(sums)))  # (R, places)
    rates = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.quantile(rates, (0.025, 0.975))
    return Rate(k, n, float(low), float(high))


def mean_of_places(hits: Sequence[bool], places: Sequence[str]) -> float | None:
    """Return the mean over places of each place's rate; None of an empty sample."""
    if not hits:
        return None
    sums, counts = _by_place(np.asarray(hits, dtype=np.float64), places)
    return float((sums / counts).mean())


def summarise(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Summarise rows of ``results.jsonl`` by method and stratum.

    Parameters
    ----------
    rows
        As in DESIGN's contract; every row counts, whatever its outcome.

    Returns
    -------
    dict
        By method, then by stratum: "required", "optional", "unrelated", and "bent" apart, whose rows are in the others
        as well. Strata without rows are left out.
    """
    summary: dict[str, dict[str, Any]] = {}
    for method in dict.fromkeys(row["method"] for row in rows):
        mine = [row for row in rows if row["method"] == method]
        strata = {name: [row for row in mine if row["stratum"] == name] for name in STRATA}
        strata["bent"] = [row for row in mine if row["bent"]]
        summary[method] = {name: _summary(part) for name, part in strata.items() if part}
    return summary


def _summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    places = [row["place"] for row in rows]
    right = [row["outcome"] == "right-accepted" for row in rows]
    answered = [
        (row["confidence"], bool(row["grades"]) and row["grades"][0] in RIGHT) for row in rows if row["verdict"]
    ]
    return {
        "n": len(rows),
        "places": len(set(places)),
        "outcomes": dict(Counter(row["outcome"] for row in rows)),
        "right_accepted": clustered_rate(right, places).as_dict(),
        "right_accepted_mean_of_places": mean_of_places(right, places),
        "wrong_accepted": clustered_rate([row["outcome"] == "wrong-accepted" for row in rows], places).as_dict(),
        "best_candidate": dict(Counter(row["grades"][0] if row["grades"] else "none" for row in rows)),
        "median_e_px": _median(_error(row) for row in rows),
        "median_e_px_right": _median(_error(row) for row, ok in zip(rows, right, strict=True) if ok),
        "median_wall_s": _median(row["seconds"]["wall"] for row in rows if row["seconds"]),
        "brier": float(np.mean([(c - ok) ** 2 for c, ok in answered])) if answered else None,
        "share_of_answers_not_right": float(np.mean([not ok for _, ok in answered])) if answered else None,
    }


def _error(row: Mapping[str, Any]) -> float:
    """The best candidate's error; a row without a candidate is as bad as can be."""
    return float(row["errors"]["e_px"]) if row["errors"] else math.inf


def _median(values: Iterable[float]) -> float | None:
    """The median; None of nothing, and where half of the values are infinite."""
    array = np.asarray(list(values), dtype=np.float64)
    middle = float(np.sort(array)[len(array) // 2]) if len(array) else math.inf
    return float(np.median(array)) if math.isfinite(middle) else None


def _by_place(values: NDArray[np.float64], places: Sequence[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    _, index = np.unique(np.asarray(places), return_inverse=True)
    sums: NDArray[np.float64] = np.bincount(index, weights=values).astype(np.float64)
    counts: NDArray[np.float64] = np.bincount(index).astype(np.float64)
    return sums, counts
