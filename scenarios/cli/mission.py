"""Command `rectbench mission`: simulated robots on real topics of ROS 2."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from rectmerge.extras import SIMULATOR, require_extras


def mission(
    suite: Annotated[str, typer.Argument(metavar="SUITE", help="A suite's name or file.")],
    seed: Annotated[int, typer.Option(min=0, help="Another seed makes another building.")] = 0,
    speed: Annotated[float, typer.Option(min=0.01, max=1000.0, help="Simulated seconds in a second.")] = 1.0,
    ends: Annotated[bool, typer.Option("--ends", help="End with the mission; else its last maps stay.")] = False,
) -> None:
    """Simulate the suite's first pair of robots, and publish their maps, scans and odometry on topics of ROS 2.

    /robot1/map, /robot1/scan, /robot1/odom, the same of robot2, and /clock: any SLAM or map merger can run on them, in
    real time or faster. /tf is published where a sourced ROS 2 has tf2_msgs.
    """
    require_extras(*SIMULATOR, "rosbags", "rclpy")
    from rectmerge.live.player import play
    from scenarios.dataset.generate import generate
    from scenarios.suites.suite import load_suite

    chosen = load_suite(suite)
    with TemporaryDirectory() as folder:
        console.note(f"rectbench: simulating a mission of {suite}")
        generate(chosen, Path(folder) / "set", pairs=1, seed=seed, form="mcap")
        bags = sorted(Path(folder).glob("set/*/bags/*"))
        if not bags:
            raise InputError(f"{suite}: no robots made its first pair; name another suite, or a --seed")
        console.note(f"rectbench: playing it at {speed:g} times its speed")
        play(bags[0], speed=speed, stays=not ends)
