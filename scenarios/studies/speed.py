"""Speed of two runs: processor time of the same answers, against a method that both runs hold."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenarios.bench.resume import MACHINE
from scenarios.scoring.statistics import clustered_difference

YARDSTICK = "keypoints-akaze"  # the label whose time stands for the machine's speed
SLOWER_AT_MOST = 0.05  # growth of the ratio
LEAST_S = 0.01  # shorter answers count as equally long: what the clock and the scheduler add
SAME_MACHINE = ("processor", "cores", "python")
Key = tuple[str, str]  # label and pair


@dataclass(frozen=True, slots=True)
class Timed:
    """Place of a row and the processor time of its answer, seconds; None where unknown."""

    place: str
    cpu_s: float | None


@dataclass(frozen=True, slots=True)
class SpeedRatio:
    """Time of a method's answers over that in the baseline, on the same pairs.

    Parameters
    ----------
    n
        Number of pairs.
    before, now
        Median processor time of an answer, seconds.
    ratio, low, high
        Geometric mean of the ratios of the pairs, with its 95 % interval by bootstrap over places; each over the
        yardstick's ratio on that pair where both runs hold it.
    """

    n: int
    before: float
    now: float
    ratio: float
    low: float
    high: float

    @property
    def is_slower(self) -> bool:
        """Whether the ratio is more than 5 % above 1, and not by chance."""
        return self.ratio > 1 + SLOWER_AT_MOST and self.low > 1


@dataclass(frozen=True, slots=True)
class SpeedComparison:
    """Speed ratios by method, and a note on what they are over, or why there are none."""

    ratios: Mapping[str, SpeedRatio]
    note: str


def compare_speed(now: Mapping[Key, Timed], before: Mapping[Key, Timed], machines: Sequence[str]) -> SpeedComparison:
    """Compare the times of two runs.

    Parameters
    ----------
    now, before
        Rows of both by label and pair.
    machines
        Machine of each run, empty where unknown. Of two machines, times are compared over the yardstick only.
    """
    common = [key for key in before if key in now and before[key].cpu_s is not None and now[key].cpu_s is not None]
    if not common:
        return SpeedComparison({}, "")
    growth = {key: _log_ratio(now[key], before[key]) for key in common}
    yardstick = {pair: value for (label, pair), value in growth.items() if label == YARDSTICK}
    if not yardstick and (len(set(machines)) > 1 or not machines[0]):
        note = f"Times are not compared: on two machines, or unknown ones, that takes `{YARDSTICK}` in both runs."
        return SpeedComparison({}, note)
    ratios = {}
    for method in dict.fromkeys(label for label, _ in common if label != YARDSTICK or not yardstick):
        keys = [key for key in common if key[0] == method and (not yardstick or key[1] in yardstick)]
        if keys:
            ratios[method] = _ratio(keys, now, before, [growth[key] - yardstick.get(key[1], 0.0) for key in keys])
    over = f"over that of `{YARDSTICK}` in the same run" if yardstick else "on one machine"
    return SpeedComparison(ratios, f"Times are compared {over}." if ratios else "")


def machine_of(run: Path) -> str:
    """Return a name of a run's machine, by its folder or a file in it; empty where it is not known."""
    try:
        record = json.loads(((run if run.is_dir() else run.parent) / MACHINE).read_text(encoding="utf-8"))
        return ", ".join(str(record[key]) for key in SAME_MACHINE)
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def _ratio(
    keys: Sequence[Key], now: Mapping[Key, Timed], before: Mapping[Key, Timed], growth: Sequence[float]
) -> SpeedRatio:
    places = [before[key].place for key in keys]
    ratio, low, high = np.exp(clustered_difference(growth, [0.0] * len(keys), places))
    medians = [float(np.median([rows[key].cpu_s or 0.0 for key in keys])) for rows in (before, now)]
    return SpeedRatio(len(keys), medians[0], medians[1], float(ratio), float(low), float(high))


def _log_ratio(now: Timed, before: Timed) -> float:
    times = [max(row.cpu_s or 0.0, LEAST_S) for row in (now, before)]
    return float(np.log(times[0] / times[1]))
