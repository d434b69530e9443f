"""Command `rectmerge`, put together from its subcommands."""

from __future__ import annotations

from rectmerge.cli import console
from rectmerge.cli.app import App
from rectmerge.cli.check import check
from rectmerge.cli.follow import follow
from rectmerge.cli.inspect import inspect
from rectmerge.cli.merge import merge
from rectmerge.cli.methods import methods
from rectmerge.cli.node import node
from rectmerge.cli.trace import trace
from rectmerge.cli.transform import transform
from rectmerge.cli.view import view
from rectmerge.cli.warm_up import warm_up

app = App(
    """Merge 2-D occupancy-grid maps of unknown rotation, scale and translation.

    Exit status: 0 yes, 1 no, 2 bad input or use, 3 ambiguous, 70 internal error, 130 interrupted.
    """
)
for command in (merge, check, follow, inspect, methods, node, trace, transform, view, warm_up):
    app.command()(command)


def main() -> None:
    """Run the command and exit with its status."""
    console.end(app, "rectmerge")
