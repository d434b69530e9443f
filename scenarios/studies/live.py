"""Live merging of pairs of robots, replayed: when each merges, and whether rightly."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.errors import RectMergeError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels, pixels_to_map_frame
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.bag_file import bag_maps, read_bag_map
from rectmerge.live.merger import LiveMerger
from rectmerge.live.replay import play
from rectmerge.similarity import Similarity
from scenarios.dataset.reader import RowSource, open_dataset
from scenarios.dataset.rosbag import ROBOTS
from scenarios.execution.executors import describe_machine
from scenarios.execution.files import require_place
from scenarios.pairs.exploring import explore
from scenarios.pairs.pair import MapPair, PairSource
from scenarios.pairs.truth import known_extent
from scenarios.scoring.markdown import markdown
from scenarios.scoring.score import RIGHT, grade, measure_errors

REFERENCE, OTHER = ROBOTS
Maps = Mapping[str, OccupancyGrid]
Recorded = tuple[float, str, OccupancyGrid | RectMergeError]  # seconds, topic, map


VERSIONS = 12  # of a map without a recording, one every five seconds: half of the simulated missions have more
PERIOD_S = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveMission:
    """Mission of two robots, merged while they explore.

    Parameters
    ----------
    pair_id, related
        The pair's.
    duration_s
        Seconds from the first map to the last.
    merged_s
        Seconds until the map of the second robot was first published rightly; None where it never was.
    overlap
        Overlap of both maps at that time, by the truth; None where there was no such time.
    final_overlap
        The same of the last maps; None where they show two places.
    wrong
        Number of published placements that were wrong; any is where the maps show two places.
    """

    pair_id: str
    related: bool
    duration_s: float
    merged_s: float | None
    overlap: float | None
    final_overlap: float | None
    wrong: int


def replay_mission(source: PairSource) -> LiveMission:
    """Play the maps of a pair to the live merger, and judge every placement that it publishes.

    They are those of the pair's bag; where it has none, the finished maps are shown as they might have grown.
    """
    (pair,) = source.pairs()
    recorded, last = _recording(source, pair)
    merged_s = overlap = None
    wrong, duration_s = 0, 0.0
    for step in play(recorded, LiveMerger(reference=REFERENCE)):
        duration_s = step.time_s
        if not step.published.events or OTHER not in step.published.placements:
            continue
        if not pair.related or not _is_right(step.published.placements[OTHER], pair, last):
            wrong += 1
        elif merged_s is None:
            merged_s, overlap = step.time_s, _true_overlap(step.published.maps, pair, last)
    return LiveMission(
        pair_id=pair.pair_id,
        related=pair.related,
        duration_s=duration_s,
        merged_s=merged_s,
        overlap=overlap,
        final_overlap=_true_overlap(last, pair, last) if pair.related else None,
        wrong=wrong,
    )


def write_live(
    dataset: str | Path, out: Path, *, on_done: Callable[[LiveMission], None] = lambda mission: None
) -> None:
    """Replay every pair of a data set, and write the page."""
    require_place(out)
    missions = []
    for source in open_dataset(dataset):
        missions.append(replay_mission(source))
        on_done(missions[-1])
    replace_file(out, page(missions, f"rectbench live {Path(dataset).name} -o {out.name}").encode())


def _recording(source: PairSource, pair: MapPair) -> tuple[Iterable[Recorded], Maps]:
    """Return the maps of a pair in time, and the last of each robot."""
    if isinstance(source, RowSource) and source.info.get("bag"):
        bag = source.folder / source.info["bag"]
        return bag_maps(bag), {robot: read_bag_map(f"{bag}:/{robot}/map") for robot in ROBOTS}
    growing = [explore(grid, VERSIONS, seed) for seed, grid in enumerate((pair.a, pair.b))]
    versions = enumerate(zip(*growing, strict=True))
    recorded = (
        (PERIOD_S * index, f"/{robot}/map", grid)
        for index, grids in versions
        for robot, grid in zip(ROBOTS, grids, strict=True)
    )
    return recorded, dict(zip(ROBOTS, (pair.a, pair.b), strict=True))


def page(missions: Sequence[LiveMission], command: str) -> str:
    """Return the page."""
    of_one_place = [each for each in missions if each.related]
    others = [each for each in missions if not each.related]
    merged = [each for each in of_one_place if each.merged_s is not None]
    wrong = sum(each.wrong > 0 for each in of_one_place)
    lines = [
        "# Live merging\n",
        "Pairs of robots, replayed through the code of `rectmerge node`: a map comes every five seconds, and is merged",
        "once two answers agree and the last is sure enough for the number of questions. Maps are those of the pair's",
        f"bag; where it has none, each finished map is shown in {VERSIONS} versions, from a drawn place outwards along",
        "its free space. *Merged*: the second robot's map was first published within the tolerance of the benchmark.",
        "*Overlap*: of both maps at that time, by the truth.\n",
        f"    {command}\n",
        f"By commit {describe_machine(command)['commit'] or 'unknown'}.\n",
    ]
    if of_one_place:
        lines.append(
            f"Pairs of one place: {len(merged)} of {len(of_one_place)} were merged rightly, {wrong} of them or of the"
            " others were published in a wrong place on the way."
        )
    if others:
        published = sum(each.wrong > 0 for each in others)
        lines.append(f"Pairs of two places: {published} of {len(others)} were published.")
    lines.append("")
    if merged:
        seconds = _quartiles([each.merged_s or 0.0 for each in merged])
        shares = _quartiles([100 * (each.merged_s or 0.0) / each.duration_s for each in merged])
        overlaps = _quartiles([each.overlap or 0.0 for each in merged], digits=2)
        heads = ("of the merged", "quarter", "median", "three quarters")
        table = [("seconds", *seconds), ("% of the recording", *shares), ("overlap then", *overlaps)]
        lines += [markdown(heads, table), "\n## Every pair of one place\n"]
    rows = [
        (
            each.pair_id,
            f"{each.duration_s:.0f}",
            "never" if each.merged_s is None else f"{each.merged_s:.0f}",
            _digits(each.overlap),
            _digits(each.final_overlap),
            str(each.wrong),
        )
        for each in of_one_place
    ]
    columns = ("pair", "seconds", "merged at", "overlap then", "overlap in the end", "wrong")
    return "\n".join([*lines, markdown(columns, rows)])


def _digits(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


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
