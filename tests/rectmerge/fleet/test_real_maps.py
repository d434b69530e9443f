"""Real maps of several places, mixed: found by RECTMERGE_REAL_MAPS."""

import json
import os
from pathlib import Path

import pytest

from rectmerge.fleet.many import align_many
from rectmerge.io.map_file import read_map

ROOT = os.environ.get("RECTMERGE_REAL_MAPS", "")
pytestmark = [
    pytest.mark.real,
    pytest.mark.slow,  # 270 pairs of real maps
    pytest.mark.skipif(not ROOT, reason="RECTMERGE_REAL_MAPS names no folder with real maps"),
]


def rows_of(name, *variants):
    folder = Path(ROOT, name, "test")
    rows = map(json.loads, (folder / "metadata.jsonl").read_text().splitlines())
    return folder, [row for row in rows if row["variant"] in variants]


def test_hand_held_maps_and_plans_of_three_places_fall_into_three_components():
    folder, rows = rows_of("real_maps", "sensor", "layout")
    place = {row[key]: row["place"] for row in rows for key in ("map_a_file_name", "map_b_file_name")}

    graph = align_many({name: read_map(folder / name) for name in place})

    assert len(graph.components) == 3
    assert len(graph.placements) >= 17  # of 18; a map that its own place contradicts is left out
    assert all(len({place[name] for name in names}) == 1 for names in graph.components)
    assert graph.asked <= 5 * len(place)


def test_robots_maps_of_eleven_places_are_joined_with_none_of_another_place():
    folder, rows = rows_of("real_places", "same-place")
    files, place = {}, {}
    for key, which in (("map_a_file_name", 0), ("map_b_file_name", 1)):  # a map that is A of no pair is the turned B
        for row in rows:
            name = row["pair_id"].split("-")[which]
            files.setdefault(name, (folder / row[key]))
            place[name] = row["place"]
    several = [name for name in files if list(place.values()).count(place[name]) >= 3]

    def read(path):
        header = path.with_suffix(".yaml")
        return read_map(header if header.exists() else path)

    graph = align_many({name: read(files[name]) for name in several})

    assert len(several) == 38
    assert all(len({place[name] for name in names}) == 1 for names in graph.components)
    assert len(graph.placements) >= 37
    assert graph.asked <= 5 * len(several)
