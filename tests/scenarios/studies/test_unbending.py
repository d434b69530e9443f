import numpy as np

from rectmerge.cli import console
from scenarios.cli.main import app
from scenarios.studies.unbending import UnbentPair, group_of, page, summary_table, unbend_pair
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement
from tests.scenarios.known_answers import pair

MACHINE = {"processor": "P", "cores": 2, "system": "S", "python": "3", "commit": None}


def measured(e_similarity, e_unbent, *, group="sensor-hard", accepted=True):
    return UnbentPair(
        group=group, pair_id="p", accepted=accepted, reason="as told", e_similarity=e_similarity, e_best=3.0,
        e_best_bend=None, e_unbent=e_unbent, double_walls_before=0.5, double_walls_after=0.2, seconds=1.0,
        align_seconds=2.0,
    )  # fmt: skip


def test_a_bent_pair_is_measured_on_its_control_points():
    a = large_building()
    truth = random_displacement(1, a.shape, spacing=200, size=14)
    b = bent_view(a, pair().pixels, truth, (480, 660))
    at_b = np.argwhere(b.free)[::997, ::-1].astype(float)
    points = np.hstack([truth.apply(pair().pixels.apply(at_b)), at_b])

    row = unbend_pair("sensor-hard", pair(a=a, b=b, control_points=points, residual_px=4.0))

    assert row.accepted, row.reason
    assert row.e_unbent < 0.5 * row.e_similarity
    assert row.e_best == 4.0
    assert row.double_walls_after < row.double_walls_before
    assert row.e_best_bend < 0.5 * row.e_similarity


def test_the_table_counts_pairs_that_changed_by_a_tenth():
    rows = [measured(10.0, 8.0), measured(10.0, 9.5), measured(10.0, 10.0, accepted=False), measured(10.0, 12.0)]

    line = summary_table({"sensor-hard": rows, "negative": [measured(None, None, group="negative")]}).splitlines()

    assert (
        line[2]
        == "| hand-held, turned and rescaled | 4 | 3 | 10.00 | 3.00 | - | 9.75 | 1 (25%) | 1 | 50 to 20 | 0.50 |"
    )
    assert line[3] == "| other places, by force | 1 | 1 | - | 3.00 | - | - | - | - | 50 to 20 | 0.50 |"


def test_the_page_names_its_command_and_each_pair():
    text = page([measured(10.0, 8.0)], MACHINE)

    assert "rectbench unbending MAPS" in text
    assert "| p | 10.00 | 3.00 | - | 8.00 | as told |" in text


def test_pairs_are_grouped_by_their_variant_or_the_source_of_their_poses():
    rows = [{"variant": "sensor-hard"}, {}, {"pose_source": "truth"}, {"pose_source": "slam"}]
    carried = {"pose_source": "odometry", "variant": "drift-0.2"}

    assert [group_of(row) for row in [*rows, carried]] == ["sensor-hard", "laser", "rigid", "bent", "carried"]


def test_the_command_names_the_data_set_that_is_missing_and_writes_nothing(tmp_path, capsys):
    status = console.run(app, "rectbench", ["unbending", str(tmp_path), "-o", str(tmp_path / "out.md")])

    assert status == 2
    assert "real_maps: not a data set" in capsys.readouterr().err
    assert not (tmp_path / "out.md").exists()
