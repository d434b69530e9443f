from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.studies.pair_measures import affine_rmse, measure_pair
from tests.sim.small_worlds import office_log


def test_what_an_affine_map_removes_is_all_of_a_stretch_and_none_of_nothing():
    log = office_log()
    straight = make_pair(log, MapSpec(), MapSpec(), 3)
    stretched = make_pair(log, MapSpec(), MapSpec(corruption=(("stretch", 5.0),)), 3)

    assert "affine" not in measure_pair(straight)
    measures = measure_pair(stretched)
    assert measures["residual"] > 0.003
    assert measures["affine"] > 0.99
    assert affine_rmse(stretched.control_points) < 1e-6
    assert 0.3 < measures["overlap"] <= 1.0
    assert measures["wall_cells"] > 0.5
