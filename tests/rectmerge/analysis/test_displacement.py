import pytest

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.io.map_file import read_map
from rectmerge.similarity import Similarity
from tests import drawing


def test_a_displacement_is_measured_where_b_is_free():
    b = read_map(drawing.DATA / "building_b.yaml")

    assert displacement_cells(b, Similarity(), Similarity(tx=3.0, ty=4.0)) == pytest.approx(5.0)
