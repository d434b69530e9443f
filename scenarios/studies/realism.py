"""Comparison of simulated pairs with real ones: the page and its contact sheet."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.contact_sheet import contact_sheet, paletted_png
from scenarios.execution.executors import WorkerDiedError, completed, describe_machine
from scenarios.execution.files import clear_folder
from scenarios.studies.examination import Finding, examine_dataset, examine_mission
from scenarios.studies.realism_page import page
from scenarios.suites.random_missions import random_sources

PAGE, SHEET = "README.md", "sheet.png"


def write_realism(
    maps: str | Path,
    out: str | Path,
    *,
    pairs: int = 200,
    executor: Executor | None = None,
    force: bool = False,
    on_done: Callable[[Finding], None] = lambda finding: None,
) -> None:
    """Compare simulated pairs of every family with real pairs, and write the page and the contact sheet.

    Parameters
    ----------
    maps
        The folder that holds the data sets ``real_maps`` and ``real_lasers``.
    out
        Folder for ``README.md`` and ``sheet.png``.
    pairs
        Missions to run, one pair each, by estimated poses.
    executor
        Where missions are run; None is this process.
    force
        Replace an earlier page.
    on_done
        Called with each finding on a simulated pair.
    """
    real = {name: examine_dataset(Path(maps) / name) for name in ("real_maps", "real_lasers")}
    folder, machine = clear_folder(out, (PAGE, SHEET), force=force), describe_machine()
    simulated = []
    for source, future in completed(executor, examine_mission, random_sources(pairs)):
        try:
            simulated.append(future.result())
        except WorkerDiedError as death:
            simulated.append(Finding(origin=source.scenario.world.family, failure=str(death), is_crash=True))
        on_done(simulated[-1])
    replace_file(folder / SHEET, paletted_png(contact_sheet()))
    replace_file(folder / PAGE, page(simulated, real, machine).encode())
