"""Answers of merges in folders, as `rectmerge merge` writes them."""

import json
import shutil

import pytest

from rectmerge.alignment import Alignment, Candidate
from rectmerge.io.map_file import read_map
from rectmerge.results.inputs import Input, inputs_json_dict
from rectmerge.similarity import Similarity
from tests import drawing

PLACES = (drawing.B_IN_A, Similarity(1.15, -1.0, 30.0, 80.0), Similarity(1.25, 2.5, 120.0, 60.0))


@pytest.fixture(scope="session")
def write_answer():
    """Put copies of the committed maps, and an answer about them, below a folder; return that of the answer."""

    def write(root, *, verdict="accepted", reason="<b>as told</b> & more", candidates=3):
        for name in ("building_a", "building_b"):
            for suffix in (".yaml", ".pgm"):
                shutil.copy(drawing.DATA / f"{name}{suffix}", root)
        a, b = root / "building_a.yaml", root / "building_b.yaml"
        grids = read_map(a), read_map(b)
        alignment = Alignment(
            verdict=verdict,
            reason=reason,
            method="told",
            confidence=0.9 if candidates else 0.0,
            candidates=tuple(
                Candidate.from_pixels(place, *grids, confidence=0.9 / (1 + k))
                for k, place in enumerate(PLACES[:candidates])
            ),
        )
        folder = root / "out"
        folder.mkdir()
        record = alignment.as_dict() | {
            "inputs": inputs_json_dict(folder, *(Input(given=str(path), path=path, greys={}) for path in (a, b)))
        }
        (folder / "alignment.json").write_text(json.dumps(record))
        return folder

    return write
