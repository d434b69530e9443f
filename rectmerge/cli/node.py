"""Command `rectmerge node`: the live merger as a node of ROS 2."""

from __future__ import annotations

from typing import Annotated

import typer

from rectmerge.cli.live_options import LiveOptions
from rectmerge.cli.method_options import MethodName


def node(
    living: LiveOptions,
    method: MethodName = None,
    ros: Annotated[
        list[str] | None,
        typer.Argument(metavar="[-- --ros-args ...]", help="Arguments of ROS: parameters, remappings."),
    ] = None,
) -> None:
    """Merge the maps of robots while they explore: a node of ROS 2, which runs until it is interrupted.

    It subscribes to the map of every robot, on /ROBOT/map unless --topics says otherwise, and to its map_updates where
    ROS has map_msgs. It publishes the merged map on /map, a transform for every robot in it, and on /diagnostics the
    reason for every robot that is not. Until something is sure, /map is the map of the reference alone. Every option is
    a parameter of ROS as well.
    """
    from rectmerge.extras import require_extras
    from rectmerge.live.settings import Settings
    from rectmerge.methods import DEFAULT_METHOD

    require_extras("rclpy")
    from rectmerge.live.node import run

    settings = Settings(
        topics=living.topics,
        reference=living.reference,
        rate=living.rate,
        accepts=living.accepts,
        method=method or DEFAULT_METHOD,
    )
    run(settings, ros or [])
