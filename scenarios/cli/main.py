"""Command `rectbench`, put together from its subcommands."""

from __future__ import annotations

from rectmerge.cli import console
from rectmerge.cli.app import App
from scenarios.cli import (
    carmen,
    catalogue,
    check_method,
    dataset,
    fleets,
    leaderboard,
    mission,
    pictures,
    run,
    studies,
    submissions,
)

app = App("Benchmark map merging on simulated and real pairs with known truth.")
COMMANDS = (  # in the order of the help
    run.run,
    dataset.generate,
    carmen.carmen,
    dataset.verify,
    studies.calibrate,
    studies.trust,
    studies.storeys,
    dataset.certify,
    fleets.fleets,
    leaderboard.tune,
    leaderboard.report,
    leaderboard.leaderboard,
    submissions.submit,
    leaderboard.growth,
    check_method.check_method,
    pictures.explain,
    pictures.figures,
    run.compare,
    pictures.demo,
    studies.headline,
    studies.results,
    studies.realism,
    studies.fit_noise,
    studies.unbending,
    studies.live,
    mission.mission,
    catalogue.suites,
    catalogue.worlds,
)
for command in COMMANDS:
    app.command()(command)


def main() -> None:
    """Run the command and exit with its status."""
    console.end(app, "rectbench")
