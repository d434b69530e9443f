import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim.missions.trajectory import write_tum
from tests.sim import naive

NUMBER = st.floats(-500, 500)


@given(st.lists(st.tuples(st.floats(0, 3600), NUMBER, NUMBER, st.floats(-3.14, 3.14)), max_size=8))
def test_a_trajectory_survives_a_file(tmp_path_factory, rows):
    table = np.array(rows).reshape(-1, 4)
    path = tmp_path_factory.mktemp("tum") / "true.tum"
    write_tum(path, table[:, 0], table[:, 1:])
    times, poses = naive.read_tum(path)

    assert np.allclose(times, table[:, 0], atol=1e-6)
    assert np.allclose(poses, table[:, 1:], atol=1e-8)


def test_the_format_is_the_benchmarks(tmp_path):
    write_tum(tmp_path / "a.tum", np.array([1.5]), np.array([[2.0, -1.0, np.pi / 2]]))
    comment, line = (tmp_path / "a.tum").read_text().splitlines()

    assert comment == "# timestamp tx ty tz qx qy qz qw"
    assert np.allclose([float(word) for word in line.split()], [1.5, 2, -1, 0, 0, 0, 0.5**0.5, 0.5**0.5])


def test_a_trajectory_with_holes_is_not_written(tmp_path):
    with pytest.raises(InputError, match="finite"):
        write_tum(tmp_path / "a.tum", np.array([0.0]), np.array([[0.0, np.nan, 0.0]]))
    with pytest.raises(InputError, match="disagree"):
        write_tum(tmp_path / "a.tum", np.zeros(2), np.zeros((1, 3)))
    assert not list(tmp_path.iterdir())
