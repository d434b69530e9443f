"""Real maps of several places, mixed. As a program, `python -m tests.rectmerge.fleet.real_fleets`, it joins all."""

from __future__ import annotations

import itertools
import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from rectmerge.analysis.double_walls import double_wall_share
from rectmerge.elastic.bend import Bend
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.fleet.many import align_many
from rectmerge.fleet.unbending import unbend_many
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.io.map_file import read_map

ROOT = os.environ.get("RECTMERGE_REAL_MAPS", "")
Placed = tuple[dict[str, OccupancyGrid], dict[str, str]]  # the maps, and the place of each, by name


def rows_of(name: str, *variants: str):
    folder = Path(ROOT, name, "test")
    rows = map(json.loads, (folder / "metadata.jsonl").read_text().splitlines())
    return folder, [row for row in rows if row["variant"] in variants]


def hand_held_maps_and_plans(most: int | None = None) -> Placed:
    """Read the maps and the plan of three places, so many of each place at most."""
    folder, rows = rows_of("real_maps", "sensor", "layout")
    place = {row[key]: row["place"] for row in rows for key in ("map_a_file_name", "map_b_file_name")}
    plans_first = sorted(place, key=lambda name: ("layout" not in name, name))
    kept = _at_most(plans_first, place, most)
    return {name: read_map(folder / name) for name in kept}, {name: place[name] for name in kept}


def robots_maps(most: int | None = None, cells: int | None = None) -> Placed:
    """Read the maps of the places with three or more, so many of each, of places whose maps have so few cells."""
    folder, rows = rows_of("real_places", "same-place")
    files, place = {}, {}
    for key, which in (("map_a_file_name", 0), ("map_b_file_name", 1)):  # a map that is A of no pair is the turned B
        for row in rows:
            name = row["pair_id"].split("-")[which]
            files.setdefault(name, folder / row[key])
            place[name] = row["place"]
    count = Counter(place.values())
    headers = {name: file.with_suffix(".yaml") for name, file in files.items() if count[place[name]] >= 3}
    maps = {name: read_map(header if header.exists() else files[name]) for name, header in headers.items()}
    large = {place[name] for name, grid in maps.items() if cells is not None and grid.occupancy.size > cells}
    kept = _at_most([name for name in maps if place[name] not in large], place, most)
    return {name: maps[name] for name in kept}, {name: place[name] for name in kept}


def _at_most(names: list[str], place: Mapping[str, str], most: int | None) -> list[str]:
    found: Counter[str] = Counter()
    kept = []
    for name in names:
        found[place[name]] += 1
        if most is None or found[place[name]] <= most:
            kept.append(name)
    return kept


def double_walls(
    maps: Mapping[str, OccupancyGrid], graph: AlignmentGraph, names: Sequence[str], bends: Mapping[str, Bend]
) -> float:
    """Return the mean share of common walls that two maps of a component show twice, after bends."""
    straight = {name: bends[name].straighten(maps[name]) if name in bends else maps[name] for name in names}
    shares = []
    for a, b in itertools.combinations(names, 2):
        b_to_a = graph.placements[a].to_reference.inverse() @ graph.placements[b].to_reference
        shares.append(
            double_wall_share(straight[a], straight[b], map_frame_to_pixels(b_to_a, straight[a], straight[b]))
        )
    known = [share for share in shares if share is not None]
    return sum(known) / len(known)


def mixed_places(graph: AlignmentGraph, place: Mapping[str, str]) -> int:
    """Count the components that hold maps of two places."""
    return sum(len({place[name] for name in names}) > 1 for names in graph.components)


if __name__ == "__main__":
    for maps, place in (hand_held_maps_and_plans(), robots_maps()):
        graph = align_many(maps)
        facts = (
            f"{len(graph.components)} components, {mixed_places(graph, place)} mixed, {len(graph.placements)} placed"
        )
        print(f"{len(maps)} maps of {len(set(place.values()))} places: {facts}, {graph.asked} pairs asked")  # noqa: T201
        for name, reason in graph.left_out.items():
            print(f"  left out: {name}: {reason}")  # noqa: T201
        bends = unbend_many(maps, graph)
        for names in graph.components:
            before, after = (double_walls(maps, graph, names, tried) for tried in ({}, bends))
            bent = sum(bends[name].accepted for name in names[1:])
            print(f"  {place[names[0]]}: {bent} of {len(names)} maps bent, double walls {before:.0%} -> {after:.0%}")  # noqa: T201
