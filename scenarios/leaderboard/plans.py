"""Plans of the leaderboard: data sets, and resumable runs of all entrants on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rectmerge.errors import InputError
from scenarios.bench.entrants import EVERYBODY
from scenarios.bench.plan import RunPlan, plan_run
from scenarios.dataset.reader import is_dataset
from scenarios.suites.suite import load_suite

SUITES = ("standard", "headline", "sweep-overlap", "sweep-noise", "sweep-scale", "sweep-accuracy", "sweep-drift")
REAL = ("real_maps", "real_lasers", "real_places")
TESTED = {"standard": "test"}  # the split on the page; the other chose the parameters
BOTH_TRACKS = ("standard",)
SETS, RUNS = "sets", "runs"


@dataclass(frozen=True, slots=True)
class Stage:
    """One run of all entrants on the pairs of a suite or of a real data set.

    Parameters
    ----------
    name
        The suite's or data set's name.
    folder
        Folder of the data set.
    knows_scale
        Whether methods get the true scale.
    is_simulated
        Whether the data set is generated where it is missing.
    """

    name: str
    folder: Path
    knows_scale: bool
    is_simulated: bool

    @property
    def run_name(self) -> str:
        """Name of the run's folder."""
        return f"{self.name}-known" if self.knows_scale else self.name

    def plan(self) -> RunPlan:
        """Plan the run of all entrants on the pairs on the page."""
        target = self.folder / TESTED.get(self.name, "")
        return plan_run(str(target), [EVERYBODY], knows_scale=self.knows_scale)


def stages(out: Path, maps: Path | None, suites: Sequence[str] = SUITES) -> list[Stage]:
    """List the runs of the leaderboard.

    Parameters
    ----------
    out
        The folder that holds ``sets/`` and ``runs/``.
    maps
        The folder of the real data sets; None leaves them out.
    suites
        Names of the simulated suites.

    Raises
    ------
    InputError
        If a suite or a real data set does not exist, before any run begins.
    """
    planned = []
    for name in suites:
        load_suite(name)
        tracks = (False, True) if name in BOTH_TRACKS else (False,)
        planned += [Stage(name, out / SETS / name, knows_scale, True) for knows_scale in tracks]
    if maps is not None:
        for name in REAL:
            if not is_dataset(maps / name):
                raise InputError(f"{maps}: must hold the data sets {', '.join(REAL)}; there is no {name}")
        planned += [Stage(name, maps / name, False, False) for name in REAL]
    return planned
