"""Demo of the main job: simulate a mission, map it, merge the maps, score and draw the answers."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.compose import compose
from rectmerge.drawing.maps import draw_map, draw_rectangles, side_by_side
from rectmerge.drawing.overlay import draw_overlay
from rectmerge.errors import SimulationError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.image_file import encode_image
from rectmerge.paper.rmap import rmap
from rectmerge.rectangles import Rectangle
from scenarios.bench.asking import TimedAnswer, ask
from scenarios.bench.contenders import make_contenders
from scenarios.bench.rows import score_answer_and_bend
from scenarios.dataset.export import MISSION_FILES, write_mission
from scenarios.execution.files import clear_folder, write_json
from scenarios.pairs.pair import MapPair
from scenarios.scoring.row import Row
from scenarios.suites.suite import load_suite
from sim.bullet import physics
from sim.missions.mission_log import MissionLog

Picture = NDArray[np.uint8]
TILE = 620, 560  # width and height of a picture in the combined one
DRAWN_RECTANGLES = 60
MISSION = "mission"  # the folder of the mission's data, in that of the pictures
OWN_FILES = (
    *("demo.png", "world.png", "map_[ab].png", "rectangles_[ab].png", "overlay_*.png", "merged_*.png", "score.json"),
    *(f"{MISSION}/{name}" for name in MISSION_FILES),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Demo:
    """Rows, pictures and times of the demo.

    Parameters
    ----------
    rows
        One scored row per contender.
    pictures
        The files written, the combined one first.
    seconds
        Wall time of each stage.
    """

    rows: Sequence[Row]
    pictures: Sequence[Path]
    seconds: dict[str, float]

    def table(self) -> tuple[list[str], list[list[str]]]:
        """Return the heads and the cells of the table for the terminal."""
        heads = ["method", "verdict", "which is", "off by cells", "m", "turn", "scale", "merged in"]
        return heads, [_cells(row) for row in self.rows]


def run_demo(out: str | Path, *, suite: str = "demo", force: bool = False, say: Callable[[str], None]) -> Demo:
    """Run the first mission of a suite through the whole chain and draw it.

    Parameters
    ----------
    out
        Folder for the pictures, ``score.json`` and the mission's data in ``mission/``, see `write_mission`.
    suite
        A suite's name or file; its contenders all get the first pair.
    force
        Clear an earlier demo's files first.
    say
        Called with a line on each stage.

    Raises
    ------
    InputError
        If the folder holds an earlier demo and `force` is off.
    SimulationError
        If the mission fails.
    """
    plan = load_suite(suite)
    source, contenders, seconds = plan.missions()[0], make_contenders([e.label for e in plan.methods], plan.methods), {}
    folder = clear_folder(out, OWN_FILES, force=force)
    started = time.perf_counter()

    def stage(done: str, line: str) -> None:
        nonlocal started
        seconds[done] = time.perf_counter() - started
        started = time.perf_counter()
        say(line)

    say("two robots explore an office ...")
    log = source.mission()
    stage("mission", f"{_explored(log)}; building their maps ...")
    pair = next(source.pairs_of(log))
    stage("maps", f"A {_size(pair.a)}, B {_size(pair.b)}, overlap {_percent(pair.overlap)}; merging ...")
    answers = {contender.label: ask(pair, contender) for contender in contenders}
    rows = [score_answer_and_bend(pair, contender, answers[contender.label]) for contender in contenders]
    stage("merging", "drawing ...")
    pictures = _write_pictures(folder, _draw(log, pair, answers, rows))
    write_mission(folder / MISSION, log, pair)
    stage("drawing", f"done in {sum(seconds.values()) + time.perf_counter() - started:.0f} s")
    write_json(folder / "score.json", {"source": source.source_id, "seconds": seconds, "rows": rows})
    return Demo(rows=rows, pictures=pictures, seconds=seconds)


def draw_world(log: MissionLog, width: int = 1240, height: int = 880) -> Picture:
    """Take the camera's picture of the building, the robots where they ended; shape (height, width, 3), RGB."""
    with physics(log.world, hz=log.spec.physics_hz) as bullet:
        for visit, robot in enumerate((log.a, log.b)):
            bullet.add_robot(robot.poses[-1], visit=visit)
        return bullet.camera(width, height)


def largest_rectangles(grid: OccupancyGrid) -> Sequence[Rectangle]:
    """Return the first rectangles of the map's R-map (Algorithm 2), the largest first."""
    return rmap(grid.free, max_rectangles=DRAWN_RECTANGLES).rectangles


def verdict_in_words(row: Row) -> str:
    """Return the outcome of a row in words."""
    known = {
        "right-accepted": "right",
        "wrong-accepted": "wrong",
        "rejected": "no answer",
        "ambiguous-with-truth": "undecided, truth among them",
        "ambiguous-without-truth": "undecided, truth missed",
    }
    return known.get(row["outcome"], str(row["outcome"]))


def _draw(log: MissionLog, pair: MapPair, answers: dict[str, TimedAnswer], rows: Sequence[Row]) -> dict[str, Picture]:
    """Draw everything, by file name, the combined picture first."""
    if pair.pixels is None:
        raise SimulationError("the two robots saw too little in common: there is no truth to draw")
    drawn = {
        "world.png": (draw_world(log), "the simulated office, two robots"),
        "map_a.png": (draw_map(pair.a), f"robot A's map, {_size(pair.a)}"),
        "map_b.png": (draw_map(pair.b), f"robot B's map, {_size(pair.b)}"),
        "overlay_truth.png": (draw_overlay(pair.a, pair.b, pair.pixels), "B on A: the truth"),
        "rectangles_a.png": (draw_rectangles(pair.a, largest_rectangles(pair.a)), "A: largest rectangles"),
        "rectangles_b.png": (draw_rectangles(pair.b, largest_rectangles(pair.b)), "B: largest rectangles"),
    }
    for row in rows:
        alignment = answers[row["method"]].attempt.value
        if alignment is not None and alignment.candidates:
            picture = draw_overlay(pair.a, pair.b, alignment.candidates[0].pixels)
            caption = f"B on A: {row['method']}, {alignment.verdict}, {verdict_in_words(row)}"
            drawn[f"overlay_{row['method']}.png"] = picture, caption
    merged = {}
    for label, answer in answers.items():
        if answer.attempt.value:
            grid = compose([pair.a, pair.b], [None, answer.attempt.value.b_to_a]).grid
            merged[f"merged_{label}.png"] = draw_map(grid)
    return {
        "demo.png": combine(list(drawn.values())),
        **{name: picture for name, (picture, _) in drawn.items()},
        **merged,
    }


def combine(pictures: Sequence[tuple[Picture, str]], *, columns: int = 3) -> Picture:
    """Set pictures with their captions side by side, each fitted into a tile of one size."""
    return side_by_side([_fitted(picture) for picture, _ in pictures], [text for _, text in pictures], columns=columns)


def _fitted(picture: Picture) -> Picture:
    """Scale a picture into the tile, in its middle on white."""
    width, height = TILE
    factor = min(width / picture.shape[1], height / picture.shape[0])
    size = round(picture.shape[1] * factor), round(picture.shape[0] * factor)
    scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC)
    tile: Picture = np.full((height, width, 3), 255, np.uint8)
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    tile[top : top + size[1], left : left + size[0]] = scaled
    return tile


def _write_pictures(folder: Path, pictures: dict[str, Picture]) -> list[Path]:
    for name, picture in pictures.items():
        replace_file(folder / name, encode_image(picture, ".png"))
    return [folder / name for name in pictures]


def _explored(log: MissionLog) -> str:
    parts = [
        f"{name} saw {len(set(robot.rooms))} of {len(log.world.rooms)} rooms in {robot.times[-1]:.0f} s"
        for name, robot in (("A", log.a), ("B", log.b))
    ]
    return ", ".join(parts)


def _size(grid: OccupancyGrid) -> str:
    return f"{grid.shape[1]} x {grid.shape[0]} cells"


def _percent(share: float | None) -> str:
    return "unknown" if share is None else f"{100 * share:.0f} %"


def _cells(row: Row) -> list[str]:
    errors, seconds = row["errors"], row["seconds"]["wall"] if row["seconds"] else math.nan
    figures = ["-"] * 4
    if errors:
        metres = "-" if errors["e_m"] is None else f"{errors['e_m']:.3f}"
        turn, scale = f"{errors['rotation_deg']:.2f} deg", f"{errors['scale_pct']:.2f} %"
        figures = [f"{errors['e_px']:.1f}", metres, turn, scale]
    return [row["method"], row["verdict"] or "-", verdict_in_words(row), *figures, f"{seconds:.2f} s"]
