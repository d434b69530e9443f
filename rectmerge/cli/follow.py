"""Command `rectmerge follow`: growing maps of a recording, merged as a live node would merge them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.app import Json
from rectmerge.cli.live_options import LiveOptions
from rectmerge.cli.merge import Folder, Force
from rectmerge.cli.method_options import MethodOptions
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.live.publication import Publication
    from rectmerge.live.replay import Step


def follow(
    bags: Annotated[
        list[Path], typer.Argument(metavar="BAG...", help="Recordings: MCAP, sqlite3 or ROS 1, one clock.")
    ],
    output: Folder,
    solving: MethodOptions,
    living: LiveOptions,
    force: Force = False,
    json: Json = False,
) -> None:
    """Play a recording of growing maps to the live merger, and write what it would have published, and when.

    It goes as fast as it can, on the clock of the recording, through the code of `rectmerge node`; no ROS is needed.
    DIR gets the last merged map as merged.yaml, and follow.json with every event, transform and reason. The status is 0
    if the maps of all robots are in the merged one, else 1.
    """
    from rectmerge.io.bag_file import bag_files
    from rectmerge.io.json_text import to_json
    from rectmerge.live.record import to_json_dict
    from rectmerge.live.replay import replay
    from rectmerge.results.folder import ResultFolder, merged_files

    folder = ResultFolder(output)
    folder.check([file for bag in bags for file in bag_files(bag)], force=force)
    merger = living.make_merger(solving)
    steps: list[Step] = []
    for step in replay(bags, merger, period_s=1 / living.rate, pattern=living.topics):
        steps = [*_eventful(steps), step]  # steps without events are not kept: each holds its maps
        if not json:
            _tell_events(step)
    last, record = steps[-1].published, to_json_dict(steps)
    if last.reference and last.reference not in last.statuses:
        raise InputError(f"--reference {last.reference} is none of the robots: {', '.join(last.statuses)}")
    files = {} if last.grid is None else merged_files(last.grid, "merged", shaded=bool(last.placements))
    files["follow.json"] = (to_json(record) + "\n").encode()
    written = folder.replace(files)
    console.tell(to_json(record) if json else _describe(last, written))
    raise typer.Exit(console.YES if all(s.verdict == "accepted" for s in last.statuses.values()) else console.NO)


def _eventful(steps: list[Step]) -> list[Step]:
    return [step for step in steps if step.published.events]


def _tell_events(step: Step) -> None:
    for event in step.published.events:
        confidence = "" if event.confidence is None else f" (confidence {event.confidence:.2f})"
        console.tell(f"{step.time_s:8.1f} s  {event.robot} {event.change}{confidence}: {event.reason}")


def _describe(last: Publication, files: list[Path]) -> str:
    """Describe what was published at the end, and name the files."""
    inside = [robot for robot, status in last.statuses.items() if status.verdict == "accepted"]
    lines = [f"{len(inside)} of {len(last.statuses)} robots are on the map of {last.reference or 'none'}"]
    width = max(map(len, last.statuses), default=0)
    lines += [f"  {robot:<{width}}  {status.message}" for robot, status in last.statuses.items()]
    lines.append(f"  written     {files[0].parent}: {', '.join(file.name for file in files)}")
    return "\n".join(lines)
