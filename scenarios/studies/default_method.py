"""Results of the default method: all rows run by one command, the page and the baseline."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from rectmerge.methods import make_method
from scenarios.bench import run as bench
from scenarios.bench.contenders import Contender
from scenarios.bench.plan import RunPlan
from scenarios.bench.resume import SUMMARY
from scenarios.dataset.reader import RowSource
from scenarios.execution.executors import describe_machine
from scenarios.execution.files import write_json
from scenarios.pairs.pair import PairSource
from scenarios.scoring.row import Row
from scenarios.studies.ablation import ABLATIONS, ablated_rows
from scenarios.studies.accuracy import baseline_of, real_tasks, simulated_tasks
from scenarios.studies.default_method_page import page

METHOD = "robust"
PAGE, BASELINE = "README.md", "baseline.json"
ABLATED_VARIANTS = ("sensor-hard", "layout-hard", "laser", "negative")  # of the related hand-held and all laser maps


@dataclass(frozen=True, slots=True)
class StudyPlan:
    """Tasks by name, the sources of the ablation, and the number of rows."""

    tasks: Mapping[str, Sequence[PairSource]]
    ablated: Sequence[PairSource]

    @classmethod
    def from_folder(cls, maps: str | Path) -> StudyPlan:
        """Plan the rows on the real maps in a folder, and on simulated suites."""
        real = real_tasks(maps)
        kept = [
            source
            for source in (*real["real_maps"], *real["real_lasers"])
            if isinstance(source, RowSource) and source.info.get("variant") in ABLATED_VARIANTS
        ]
        return cls({**real, **simulated_tasks()}, kept)

    @property
    def row_count(self) -> int:
        """Number of rows of all tasks and ablations."""
        pairs = sum(len(source.pair_ids) for sources in self.tasks.values() for source in sources)
        return pairs + len(ABLATIONS) * len(self.ablated)


def write_results(
    plan: StudyPlan,
    out: str | Path,
    *,
    force: bool = False,
    on_rows: Callable[[Sequence[Row]], None] = lambda rows: None,
) -> None:
    """Run every row in this process, on one core, and write the page and the baseline.

    Parameters
    ----------
    plan
        Tasks and ablations.
    out
        Folder for ``README.md`` and ``baseline.json``; the rows go into ``run/``, one run's folder per task.
    force
        Clear earlier runs in the folder. Otherwise an interrupted command is resumed, by the present code.
    on_rows
        Called with rows as they come.

    Raises
    ------
    InputError
        If the folder holds complete earlier runs and `force` is off, or cannot be written.
    """
    folder, threads = Path(out), cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        rows = _run(plan.tasks, folder / "run", force=force, on_rows=on_rows)
        pairs = [pair for source in plan.ablated for pair in source.pairs()]
        ablated = {}
        for ablation in ABLATIONS:
            ablated[ablation.name] = list(ablated_rows(ablation, pairs))
            on_rows(ablated[ablation.name])
    finally:
        cv2.setNumThreads(threads)
    write_json(folder / BASELINE, baseline_of(rows))
    replace_file(folder / PAGE, page(rows, ablated, describe_machine()).encode())


def _run(
    tasks: Mapping[str, Sequence[PairSource]],
    folder: Path,
    *,
    force: bool,
    on_rows: Callable[[Sequence[Row]], None],
) -> list[Row]:
    if not force and all((folder / name / SUMMARY).exists() for name in tasks):
        raise InputError(f"{folder}: holds earlier results; --force clears them")
    contenders, rows = [Contender(label=METHOD, method=make_method(METHOD))], []
    for name, sources in tasks.items():
        plan = RunPlan(suite=name, sources=sources, contenders=contenders)
        bench.run(plan, folder / name, callbacks=bench.RunCallbacks(on_rows=on_rows), force=force)
        rows += bench.read_rows(folder / name)
    return rows
