"""Examination of simulated and real pairs: the measures of each, and failures of the simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from rectmerge.errors import RectMergeError, SimulationError
from scenarios.dataset.reader import open_dataset
from scenarios.execution.attempt import peak_memory_mb
from scenarios.studies.mission_faults import mission_faults
from scenarios.studies.pair_measures import measure_pair
from scenarios.suites.mission_source import MissionSource


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Measures of one pair, or the reason why there is none.

    Parameters
    ----------
    origin
        The family of its building, or its real data set.
    measures
        By name, see `measure_pair`; empty where there is no pair.
    failure
        Reason why the mission gave no pair, or empty; `is_crash` unless it is a refusal by the simulation.
    faults
        Of the mission, see `mission_faults`.
    discarded
        Number of missions that were discarded before one succeeded.
    wanted_overlap
        By the scenario.
    peak_mb
        Peak of the process's memory so far.
    """

    origin: str
    measures: Mapping[str, float] = field(default_factory=dict)
    failure: str = ""
    is_crash: bool = False
    faults: tuple[str, ...] = ()
    discarded: int = 0
    wanted_overlap: float | None = None
    peak_mb: float | None = None


def examine_mission(source: MissionSource) -> Finding:
    """Run a mission, make its pair, and measure both."""
    family, overlap = source.scenario.world.family, source.scenario.mission.overlap
    try:
        log = source.mission()
        (pair,) = source.pairs_of(log)
    except RectMergeError as error:
        is_crash = not isinstance(error, SimulationError)
        return Finding(
            origin=family, failure=str(error), is_crash=is_crash, wanted_overlap=overlap, peak_mb=peak_memory_mb()
        )
    except Exception as error:  # noqa: BLE001 - a crash is counted
        return Finding(origin=family, failure=f"{type(error).__name__}: {error}", is_crash=True, wanted_overlap=overlap)
    return Finding(
        origin=family,
        measures=measure_pair(pair),
        faults=mission_faults(log),
        discarded=len(log.discarded),
        wanted_overlap=overlap,
        peak_mb=peak_memory_mb(),
    )


def examine_dataset(dataset: Path) -> list[Finding]:
    """Measure the related pairs of a real data set that are no copies: the variants "sensor" and "laser"."""
    return [
        Finding(origin=dataset.name, measures=measure_pair(pair))
        for source in open_dataset(dataset)
        for pair in source.pairs()
        if pair.related and pair.info.get("variant") in ("sensor", "laser")
    ]
