"""Live merging of simulated missions, replayed from their bags: when each merges, and whether rightly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels, pixels_to_map_frame
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.bag_file import read_bag_map
from rectmerge.live.merger import LiveMerger
from rectmerge.live.replay import replay
from rectmerge.similarity import Similarity
from scenarios.dataset.reader import RowSource, open_dataset
from scenarios.dataset.rosbag import ROBOTS
from scenarios.execution.executors import describe_machine
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import known_extent
from scenarios.scoring.score import RIGHT, grade, measure_errors
from scenarios.studies.headline import markdown

REFERENCE, OTHER = ROBOTS
Maps = Mapping[str, OccupancyGrid]


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveMission:
    """Mission of two robots, merged while they explore.

    Parameters
    ----------
    pair_id
        The pair's.
    duration_s
        Simulated seconds from the first map to the last.
    merged_s
        Seconds until the map of the second robot was first published rightly; None where it never was.
    overlap
        Overlap of both maps at that time, by the truth; None where there was no such time.
    final_overlap
        The same of the last maps.
    wrong
        Number of published placements that were wrong.
    """

    pair_id: str
    duration_s: float
    merged_s: float | None
    overlap: float | None
    final_overlap: float
    wrong: int


def bag_sources(dataset: str | Path) -> list[RowSource]:
    """Return the pairs of a data set that have bags.

    Raises
    ------
    InputError
        If none has: it was not generated with ``--format mcap`` or ``rosbag1``.
    """
    sources = [each for each in open_dataset(dataset) if isinstance(each, RowSource) and "bag" in each.info]
    if not sources:
        raise InputError(f"{dataset}: no pair has a bag; make the data set with rectbench generate --format mcap")
    return sources


def replay_mission(source: RowSource) -> LiveMission:
    """Play the bag of a pair to the live merger, and judge every placement that it publishes."""
    bag, (pair,) = source.folder / source.info["bag"], source.pairs()
    last = {robot: read_bag_map(f"{bag}:/{robot}/map") for robot in ROBOTS}
    merged_s = overlap = None
    wrong, duration_s = 0, 0.0
    for step in replay([bag], LiveMerger(reference=REFERENCE)):
        duration_s = step.time_s
        if not step.published.events or OTHER not in step.published.placements:
            continue
        if not _is_right(step.published.placements[OTHER], pair, last):
            wrong += 1
        elif merged_s is None:
            merged_s, overlap = step.time_s, _true_overlap(step.published.maps, pair, last)
    return LiveMission(
        pair_id=source.pair_id,
        duration_s=duration_s,
        merged_s=merged_s,
        overlap=overlap,
        final_overlap=_true_overlap(last, pair, last),
        wrong=wrong,
    )


def write_live(
    dataset: str | Path, out: Path, *, on_done: Callable[[LiveMission], None] = lambda mission: None
) -> None:
    """Replay every pair of a data set that has a bag, and write the page."""
    missions = []
    for source in bag_sources(dataset):
        missions.append(replay_mission(source))
        on_done(missions[-1])
    replace_file(out, page(missions, f"rectbench live {dataset} -o {out}").encode())


def page(missions: Sequence[LiveMission], command: str) -> str:
    """Return the page."""
    merged = [each for each in missions if each.merged_s is not None]
    wrong = sum(each.wrong for each in missions)
    lines = [
        "# Live merging\n",
        "Missions of two simulated robots, replayed from their bags through the code of `rectmerge node`: a map comes",
        "every five simulated seconds, and is merged once two answers agree and the last is sure enough for the number",
        "of questions. *Merged*: the second robot's map was first published within the tolerance of the benchmark.",
        "*Overlap*: of both maps at that time, by the truth.\n",
        f"    {command}\n",
        f"By commit {describe_machine(command)['commit'] or 'unknown'}.\n",
        f"{len(merged)} of {len(missions)} missions were merged rightly; {wrong} published placements were wrong.\n",
    ]
    if merged:
        seconds = _quartiles([each.merged_s or 0.0 for each in merged])
        shares = _quartiles([100 * (each.merged_s or 0.0) / each.duration_s for each in merged])
        overlaps = _quartiles([each.overlap or 0.0 for each in merged], digits=2)
        heads = ("of the merged", "quarter", "median", "three quarters")
        table = [("seconds", *seconds), ("% of the mission", *shares), ("overlap then", *overlaps)]
        lines += [markdown(heads, table), "\n## Every mission\n"]
    rows = [
        (
            each.pair_id,
            f"{each.duration_s:.0f}",
            "never" if each.merged_s is None else f"{each.merged_s:.0f}",
            "" if each.overlap is None else f"{each.overlap:.2f}",
            f"{each.final_overlap:.2f}",
            str(each.wrong),
        )
        for each in missions
    ]
    columns = ("pair", "seconds", "merged at", "overlap then", "overlap in the end", "wrong")
    return "\n".join([*lines, markdown(columns, rows)])


def _quartiles(values: Sequence[float], digits: int = 0) -> list[str]:
    return [f"{value:.{digits}f}" for value in np.percentile(values, [25, 50, 75])]


def _is_right(placement: Similarity, pair: MapPair, last: Maps) -> bool:
    """Return whether a placement is right by the rule of the benchmark, on the last maps."""
    assert pair.residual_px is not None
    pixels = map_frame_to_pixels(placement, last[REFERENCE], last[OTHER])
    return grade(measure_errors(pixels, pair), pair.residual_px / known_extent(pair.a)) in RIGHT


def _true_overlap(maps: Maps, pair: MapPair, last: Maps) -> float:
    """Return the overlap of two maps of a mission, placed by the truth."""
    assert pair.pixels is not None
    truth = pixels_to_map_frame(pair.pixels, last[REFERENCE], last[OTHER])
    a, b = maps[REFERENCE], maps[OTHER]
    return measure_agreement(a, b, map_frame_to_pixels(truth, a, b)).overlap
