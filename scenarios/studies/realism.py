"""Realism of simulated pairs: their measures beside those of real pairs, and the robustness of the simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.quality import measure_quality
from rectmerge.errors import RectMergeError, SimulationError
from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.contact_sheet import contact_sheet, paletted_png
from scenarios.dataset.reader import open_dataset
from scenarios.execution.attempt import peak_memory_mb
from scenarios.execution.executors import WorkerDiedError, completed, describe_machine
from scenarios.execution.files import clear_folder
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse, known_extent
from scenarios.studies.realism_page import page
from scenarios.suites.random_missions import random_sources
from scenarios.suites.suite import MissionSource
from sim.missions.mission_log import STUCK_SHARE, MissionLog, RobotLog
from sim.world import World

PAGE, SHEET = "README.md", "sheet.png"
STEP_M = 0.03  # between the points of a robot's path that are looked up in the plan
PLAN_M = 0.02  # cells of that plan
EXACT_BELOW_PX = 1e-3  # a residual below this is rounding: there is nothing for an affine map to remove


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one pair is like, or why there is none.

    Parameters
    ----------
    kind
        Where the pair comes from: a family of buildings, or a real set.
    figures
        By name, see `figures_of`; empty where there is no pair.
    failure
        Empty, or why the mission came to nothing; `is_crash` where that was no honest "no".
    faults
        What a mission must not do: a robot through a wall, or stuck without saying so.
    discarded
        Tries at the mission that were discarded before one succeeded.
    wanted
        The overlap that was asked for.
    peak_mb
        The highest memory of the process so far.
    """

    kind: str
    figures: Mapping[str, float] = field(default_factory=dict)
    failure: str = ""
    is_crash: bool = False
    faults: tuple[str, ...] = ()
    discarded: int = 0
    wanted: float | None = None
    peak_mb: float | None = None


def write_realism(
    maps: str | Path,
    out: str | Path,
    *,
    pairs: int = 200,
    executor: Executor | None = None,
    force: bool = False,
    on_done: Callable[[Finding], None] = lambda finding: None,
) -> None:
    """Make pairs of every kind, measure them and the real ones, and write the page and the contact sheet.

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
        Told of each finding on a simulated pair.
    """
    folder, machine = clear_folder(out, (PAGE, SHEET), force=force), describe_machine()
    real = {name: real_findings(Path(maps) / name) for name in ("real_maps", "real_lasers")}
    simulated = []
    for source, future in completed(executor, examine, random_sources(pairs)):
        try:
            simulated.append(future.result())
        except WorkerDiedError as death:
            simulated.append(Finding(kind=source.scenario.world.family, failure=str(death), is_crash=True))
        on_done(simulated[-1])
    replace_file(folder / SHEET, paletted_png(contact_sheet()))
    replace_file(folder / PAGE, page(simulated, real, machine).encode())


def examine(source: MissionSource) -> Finding:
    """Run a mission, make its pair, and measure both."""
    family, wanted = source.scenario.world.family, source.scenario.mission.overlap
    try:
        log = source.mission()
        (pair,) = source.pairs_of(log)
    except RectMergeError as error:
        is_crash = not isinstance(error, SimulationError)
        return Finding(kind=family, failure=str(error), is_crash=is_crash, wanted=wanted, peak_mb=peak_memory_mb())
    except Exception as error:  # noqa: BLE001 - a crash is what this counts
        return Finding(kind=family, failure=f"{type(error).__name__}: {error}", is_crash=True, wanted=wanted)
    return Finding(
        kind=family,
        figures=figures_of(pair),
        faults=faults_of(log),
        discarded=len(log.discarded),
        wanted=wanted,
        peak_mb=peak_memory_mb(),
    )


def real_findings(dataset: Path) -> list[Finding]:
    """Measure the related pairs of a real set that are not copies: the variants "sensor" and "laser"."""
    return [
        Finding(kind=dataset.name, figures=figures_of(pair))
        for source in open_dataset(dataset)
        for pair in source.pairs()
        if pair.related and pair.info.get("variant") in ("sensor", "laser")
    ]


def figures_of(pair: MapPair) -> dict[str, float]:
    """Measure a pair.

    Returns
    -------
    dict
        ``overlap``; ``wall_cells``, the mean of both maps' median wall thickness, in cells; ``speckle`` of the map that
        has more; and where the truth is not exact ``residual``, the residual over L, and ``affine``, the share of
        it that the best affine map removes.
    """
    maps = [measure_quality(grid) for grid in (pair.a, pair.b)]
    found = {"overlap": pair.overlap or 0.0, "speckle": max(quality.speckle for quality in maps)}
    found["wall_cells"] = float(np.mean([quality.wall_thickness_cells or 0.0 for quality in maps]))
    points = pair.control_points
    if points is not None and pair.residual_px is not None and pair.residual_px > EXACT_BELOW_PX:
        found["residual"] = pair.residual_px / known_extent(pair.a)
        found["affine"] = 1.0 - affine_rmse(points) / pair.residual_px
    return found


def affine_rmse(points: NDArray[np.float64]) -> float:
    """Return the RMSE of the best affine map on control points (N, 4), in A's pixels."""
    from_b = np.column_stack([points[:, 2:], np.ones(len(points))])
    matrix = np.linalg.lstsq(from_b, points[:, :2], rcond=None)[0].T
    return control_point_rmse(matrix, points)


def faults_of(log: MissionLog) -> tuple[str, ...]:
    """List what a mission must not do."""
    faults = []
    for visit, (name, robot) in enumerate((("A", log.a), ("B", log.b))):
        if goes_through_walls(log.world, robot, visit):
            faults.append(f"robot {name} went through a wall")
        if robot.stuck_s > STUCK_SHARE * float(robot.times[-1]) and "no progress" not in robot.note:
            faults.append(f"robot {name} was stuck for {robot.stuck_s:.0f} s and did not say so")
    return tuple(faults)


def goes_through_walls(world: World, robot: RobotLog, visit: int) -> bool:
    """Whether the middle of a robot was ever in a wall, a pane, or something tall that stood there."""
    here = world.at_visit(visit)
    solid = replace(here, rooms=(), doors=(), floor=()).raster(PLAN_M).occupied
    places = robot.poses[:, :2]
    lengths = np.hypot(*np.diff(places, axis=0).T)
    shares = [np.linspace(0, 1, max(2, math.ceil(length / STEP_M)))[:, None] for length in lengths]
    path = [p + share * (q - p) for p, q, share in zip(places[:-1], places[1:], shares, strict=True)]
    cols, up = np.floor(np.concatenate(path) / PLAN_M).astype(np.intp).T
    return bool(solid[solid.shape[0] - 1 - up, cols].any())
