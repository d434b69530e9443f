"""Comparison of simulated maps and pairs with real ones: the pages and their contact sheets."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.contact_sheet import contact_sheet, paletted_png
from scenarios.dataset.reader import open_dataset
from scenarios.execution.executors import WorkerDiedError, completed, describe_machine
from scenarios.execution.files import clear_folder
from scenarios.studies.examination import Finding, examine_dataset, examine_mission
from scenarios.studies.map_population import REAL, run_missions
from scenarios.studies.map_realism import PAGE as MAPS_PAGE
from scenarios.studies.map_realism import SHEET as MAPS_SHEET
from scenarios.studies.map_realism import compare_maps, write_map_realism
from scenarios.studies.realism_page import page
from scenarios.suites.random_missions import random_sources

PAGE, SHEET = "README.md", "sheet.png"
PAIR_SETS = ("real_maps", "real_lasers")  # of the page on pairs


def write_realism(
    maps: str | Path,
    out: str | Path,
    *,
    missions: int = 60,
    pairs: int = 200,
    executor: Executor | None = None,
    force: bool = False,
    on_done: Callable[[str], None] = lambda origin: None,
) -> None:
    """Compare simulated maps and pairs with real ones, and write a page and a contact sheet of each.

    Parameters
    ----------
    maps
        The folder that holds the data sets ``real_maps``, ``real_lasers`` and ``real_places``.
    out
        Folder for ``README.md`` and ``sheet.png``, ``maps.md`` and ``maps.png``.
    missions
        Missions of the suite `standard` whose maps are compared with those of robots; 0 leaves that page as it is.
    pairs
        Missions to run, one pair each, by estimated poses; 0 leaves that page as it is.
    executor
        Where missions are run; None is this process.
    force
        Replace an earlier page.
    on_done
        Called with the name of each mission that has been run.
    """
    for name in sorted({*(REAL if missions else ()), *(PAIR_SETS if pairs else ())}):
        open_dataset(Path(maps) / name)  # refused before anything is cleared or simulated
    folder, machine = Path(out), describe_machine()
    for count, files in ((missions, (MAPS_PAGE, MAPS_SHEET)), (pairs, (PAGE, SHEET))):
        if count:
            clear_folder(folder, files, force=force)
    if missions:
        mapped = run_missions(missions, split="test", executor=executor, on_done=on_done)
        write_map_realism(compare_maps(Path(maps), mapped), folder, machine)
    if pairs:
        _write_pairs(Path(maps), folder, pairs, executor, on_done)


def _write_pairs(
    maps: Path, folder: Path, pairs: int, executor: Executor | None, on_done: Callable[[str], None]
) -> None:
    """Write the page that compares pairs, and its contact sheet."""
    real = {name: examine_dataset(maps / name) for name in PAIR_SETS}
    simulated = []
    for source, future in completed(executor, examine_mission, random_sources(pairs)):
        try:
            simulated.append(future.result())
        except WorkerDiedError as death:
            simulated.append(Finding(origin=source.scenario.world.family, failure=str(death), is_crash=True))
        on_done(simulated[-1].origin)
    replace_file(folder / SHEET, paletted_png(contact_sheet()))
    replace_file(folder / PAGE, page(simulated, real, describe_machine()).encode())
