"""Merges of many maps by the command, and a method that answers from the truth of a drawn fleet."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from tests import drawing
from tests.rectmerge.fleet.fleets import Fleet, Oracle

MAPS = [drawing.DATA / f"building_{name}.yaml" for name in "abc"]


@dataclass(frozen=True)
class Judge(Oracle):
    """Oracle that needs no check by the default method."""

    def align_by(self, hint, a, b, **asked):
        return self.align(a, b, **asked)


def rectmerge(*words: object) -> int:
    """Run the command and return its status."""
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


def save_fleet(folder: Path, made: Fleet) -> dict[str, Path]:
    """Write a fleet's maps to files, and put what is read from them into the fleet; return the files by name."""
    for name, grid in made.maps.items():
        write_map(OccupancyGrid(grid.occupancy, 0.05 * made.poses[name].scale), folder / f"{name}.yaml")
        made.maps[name] = read_map(folder / f"{name}.yaml")
    return {name: folder / f"{name}.yaml" for name in made.maps}
