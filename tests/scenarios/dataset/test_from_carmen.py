import numpy as np
import pytest

import rectmerge as rm
from rectmerge.errors import InputError, SimulationError
from rectmerge.grid import OccupancyGrid
from scenarios.dataset.from_carmen import CarmenSuite
from scenarios.pairs.truth import control_point_rmse
from sim.importers import read_carmen
from sim.importers.survey import survey
from tests.sim.carmen_logs import flaser, office_walk, robotlaser, write_log
from tests.sim.small_worlds import wall_distance

WALK = office_walk()


def suite_of(folder, *, is_corrected=True, form=flaser, **options):
    log = read_carmen(write_log(folder / "walk.log", form(WALK, is_corrected=is_corrected)))
    return CarmenSuite(name="walk", survey=survey(log), **options)


def pairs_of(suite):
    return [pair for source in suite.sources() for pair in source.pairs()]


def in_world(pair, name):
    """Where the control points of a map lie in the world, by the origin that the pair tells."""
    grid, columns = (pair.a, slice(0, 2)) if name == "a" else (pair.b, slice(2, 4))
    origin, resolution = tuple(pair.info[f"origin_{name}"]), pair.info[f"resolution_{name}"]
    return OccupancyGrid(grid.occupancy, resolution, origin).pixel_to_map(pair.control_points[:, columns])


@pytest.mark.parametrize("form", [flaser, robotlaser])
def test_both_maps_show_the_control_points_where_the_world_has_walls(tmp_path, form):
    (pair,) = pairs_of(suite_of(tmp_path, form=form, resolution_b=0.06))
    a, b = (in_world(pair, name) for name in "ab")

    assert 200 <= len(pair.control_points) <= 500
    assert np.abs(a - b).max() < 1e-6
    assert wall_distance(WALK.world, a).max() < 0.1
    assert pair.pixels.scale == pytest.approx(0.06 / 0.05)
    assert pair.residual_px < 1e-6


def test_parts_of_a_raw_log_are_mapped_alone_and_the_truth_is_of_the_whole(tmp_path):
    (pair,) = pairs_of(suite_of(tmp_path, is_corrected=False))
    a, b = (in_world(pair, name) for name in "ab")

    assert pair.info["pose_source"] == "slam"
    assert 0 < pair.info["ate_b_m"] < 0.1
    assert np.hypot(*(a - b).T).mean() < 0.1
    assert wall_distance(WALK.world, a).mean() < 0.15  # the whole log starts where the wheels do, at the truth
    assert not pair.info["bent"]


@pytest.mark.parametrize("is_corrected", [True, False])
def test_align_finds_the_truth_of_a_cut_pair(tmp_path, is_corrected):
    (pair,) = pairs_of(suite_of(tmp_path, is_corrected=is_corrected))
    alignment = rm.align(pair.a, pair.b)

    assert alignment
    assert control_point_rmse(alignment.candidates[0].pixels.matrix, pair.control_points) < 2.0


def test_shared_scans_are_in_both_maps(tmp_path):
    apart, whole = (pairs_of(suite_of(tmp_path, shared=shared))[0] for shared in (0.0, 1.0))

    assert whole.overlap > 0.98 > apart.overlap


def test_several_pairs_are_cut_at_several_places_and_turned_anew(tmp_path):
    suite = suite_of(tmp_path, pairs=3)
    pairs = pairs_of(suite)

    assert [pair.info["cut"] for pair in pairs] == [0.3, 0.5, 0.7]
    assert len({pair.info["turn_a_deg"] for pair in pairs}) == 3
    assert {pair.place for pair in pairs} == {"carmen/walk"}
    assert [pair.pair_id for pair in pairs] == [source.source_id for source in suite.sources()]
    assert all(source.is_related(pair.pair_id) for source, pair in zip(suite.sources(), pairs, strict=True))


def test_the_seed_turns_the_maps_and_the_same_gives_the_same(tmp_path):
    first, again, other = (pairs_of(suite_of(tmp_path, seed=seed))[0] for seed in (1, 1, 2))

    assert np.array_equal(first.a.occupancy, again.a.occupancy)
    assert np.array_equal(first.control_points, again.control_points)
    assert first.info["turn_a_deg"] != other.info["turn_a_deg"]


def test_parts_that_have_nothing_in_common_are_refused(tmp_path):
    far = WALK.poses + np.where(np.arange(len(WALK.poses)) < len(WALK.poses) // 2, 0.0, 100.0)[:, None] * [1, 0, 0]
    log = read_carmen(write_log(tmp_path / "walk.log", flaser(WALK.replaced(poses=far), is_corrected=True)))

    with pytest.raises(SimulationError, match=r"too few surfaces in common .*--cut.*--shared"):
        pairs_of(CarmenSuite(name="walk", survey=survey(log)))


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"pairs": 0}, "pairs must be 1"),
        ({"seed": -1}, "seed >= 0"),
        ({"resolution_b": 7.0}, "resolution must be 0.005 to 1"),
        ({"cut": 0.95}, "cut must be 0.1 to 0.9 of the log, got 0.95"),
        ({"shared": 1.5}, "shared must be 0 to 1 of the log, got 1.5"),
    ],
)
def test_values_out_of_range_are_named(tmp_path, options, complaint):
    with pytest.raises(InputError, match=complaint):
        suite_of(tmp_path, **options)


def test_a_part_of_few_scans_is_refused(tmp_path):
    with pytest.raises(InputError, match="scans 0 to 9 of 188 with movement are too few"):
        suite_of(tmp_path).survey.part(0, 9)
