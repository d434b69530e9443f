"""Hand-held maps of three places and their floor plans, mixed: found by RECTMERGE_REAL_MAPS."""

import json
import os
from pathlib import Path

import pytest

from rectmerge.fleet.many import align_many
from rectmerge.io.map_file import read_map

ROOT = os.environ.get("RECTMERGE_REAL_MAPS")


@pytest.mark.real
@pytest.mark.slow  # 80 pairs of real maps
@pytest.mark.skipif(not ROOT, reason="RECTMERGE_REAL_MAPS names no folder with real maps")
def test_mixed_maps_of_three_places_fall_into_three_components():
    folder = Path(ROOT or "", "real_maps", "test")
    rows = [json.loads(line) for line in (folder / "metadata.jsonl").read_text().splitlines()]
    place = {
        row[key]: row["place"]
        for row in rows
        if row["variant"] in ("sensor", "layout")
        for key in ("map_a_file_name", "map_b_file_name")
    }

    graph = align_many({name: read_map(folder / name) for name in place})

    assert sorted(len(names) for names in graph.components) == [5, 5, 8]
    assert all(len({place[name] for name in names}) == 1 for names in graph.components)
    assert graph.asked <= 5 * len(place)
