from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from tests import drawing

trinary = arrays(
    np.int8, array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=9), elements=st.sampled_from([-1, 0, 100])
)
finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(
    trinary.filter(lambda cells: (cells == 0).any()),
    st.none() | st.floats(min_value=0, exclude_min=True, allow_infinity=False),
    st.tuples(finite, finite, finite),
    st.sampled_from([".pgm", ".png"]),
)
def test_a_trinary_map_comes_back_bit_for_bit(tmp_path, cells, resolution, origin, suffix):
    write_map(OccupancyGrid(cells, resolution, origin), tmp_path / "m.yaml", image_suffix=suffix)

    back = read_map(tmp_path / "m.yaml")

    assert (back.occupancy == cells).all()
    assert (back.resolution, back.origin) == (resolution, origin)


@pytest.mark.parametrize("number", [np.float64(0.05), np.float32(0.05), np.int64(2)])
def test_a_resolution_may_be_a_number_of_numpys(tmp_path, number):
    write_map(OccupancyGrid(np.zeros((2, 2), np.int8), number, (number, number, number)), tmp_path / "m.yaml")

    assert read_map(tmp_path / "m.yaml").resolution == pytest.approx(float(number))


def test_writing_leaves_only_the_two_files(tmp_path):
    write_map(drawing.building(resolution=0.05), tmp_path / "m.yaml")

    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.pgm", "m.yaml"]


def test_an_interrupted_write_leaves_the_old_map(tmp_path, monkeypatch):
    write_map(drawing.building(resolution=0.05), tmp_path / "m.yaml")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    replace = Path.replace

    def fail(self: Path, target: Path) -> Path:
        if self.suffix == ".part":
            raise OSError(28, "No space left on device")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(MapFileError, match=r"m\.pgm: cannot be written: No space left on device"):
        write_map(drawing.building(resolution=0.10), tmp_path / "m.yaml")

    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


@pytest.mark.parametrize("name", ["m.pgm", "m", "missing/m.yaml"])
def test_a_name_that_cannot_be_written_is_refused(tmp_path, name):
    with pytest.raises(MapFileError, match=name.split("/")[-1].split(".")[0]):
        write_map(drawing.building(), tmp_path / name)
