import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.io.map_file import read_map
from scenarios.dataset.export import write_mission
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.pairs.truth import control_point_rmse
from sim.missions.mission_log import MissionLog, RobotLog
from tests.sim import naive
from tests.sim.small_worlds import box_world, office_log, wall_distance

LOG = office_log()
TURNED = MapSpec(resolution=0.06, turn_deg=35.0, turn="image")


def wall_points(path):
    """The centres of a written map's wall cells, in its map frame."""
    grid = read_map(path)
    return grid.pixel_to_map(np.argwhere(grid.occupied)[:, ::-1])


def test_a_mission_is_written_whole_and_reads_back(tmp_path):
    written = write_mission(tmp_path / "out", LOG, make_pair(LOG, MapSpec(), TURNED, 1))

    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {path.name for path in written}
    maps = {f"{name}.{suffix}" for name in ("robot_a", "robot_b", "world") for suffix in ("yaml", "png")}
    assert names == maps | {"robot_a.truth.tum", "robot_b.truth.tum", "mission.npz", "truth.json"}
    assert np.array_equal(MissionLog.load(tmp_path / "out/mission.npz").a.ranges, LOG.a.ranges)


def box_log() -> MissionLog:
    """Two robots that look around in one room, whose walls' inner sides are at 0.2 and 5.8, and at 0.2 and 3.8."""
    world, lidar = box_world(6.0, 4.0), LOG.spec.a.lidar
    poses = np.array([[1.53, 2.07, 0.4], [5.0, 2.5, 2.0], [1.2, 1.0, -1.0]])
    ranges = np.array([naive.cast(world, pose, lidar.angles, lidar.max_range_m) for pose in poses])
    robot = RobotLog(times=np.arange(3.0), poses=poses, odometry=poses, ranges=ranges)
    return MissionLog(world=world, spec=LOG.spec, seed=3, a=robot, b=robot)


def test_the_corners_of_a_room_are_within_half_a_cell_of_those_of_the_written_maps(tmp_path):
    write_mission(tmp_path, box_log())
    world = read_map(tmp_path / "world.yaml")
    room = world.pixel_to_map(np.argwhere(world.free)[:, ::-1])

    for name in "ab":
        walls = wall_points(tmp_path / f"robot_{name}.yaml")
        assert np.allclose(walls.min(axis=0), [0.2, 0.2], atol=0.025 + 1e-9)
        assert np.allclose(walls.max(axis=0), [5.8, 3.8], atol=0.025 + 1e-9)
    assert np.allclose([room.min(axis=0), room.max(axis=0)], [[0.225, 0.225], [5.775, 3.775]])


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(st.sampled_from(["frame", "image"]), st.floats(-180, 180), st.floats(0.04, 0.1))
def test_written_walls_stand_in_the_world_however_the_map_was_turned(tmp_path_factory, turn, degrees, resolution):
    folder = tmp_path_factory.mktemp("out")
    spec = MapSpec(resolution=resolution, turn_deg=degrees, turn=turn)
    write_mission(folder, LOG, make_pair(LOG, spec, spec, 2))

    half = 0.5 if turn == "frame" else 1.0  # half a cell to its centre; the nearest neighbour may be half a cell off
    for name in "ab":
        away = wall_distance(LOG.world, wall_points(folder / f"robot_{name}.yaml"))
        assert away.mean() < half * resolution
        assert away.max() < 1.4143 * half * resolution


def test_the_truth_fits_the_written_maps(tmp_path):
    write_mission(tmp_path, LOG, make_pair(LOG, MapSpec(turn_deg="random"), TURNED, 1))
    truth = json.loads((tmp_path / "truth.json").read_text())
    a, b = (read_map(tmp_path / f"robot_{name}.yaml") for name in "ab")
    points = np.array(truth["control_points"])

    assert np.allclose(a.pixel_to_map(points[:, :2]), b.pixel_to_map(points[:, 2:]), atol=1e-3)
    assert control_point_rmse(truth["pixels"], points) < 1e-3
    assert (truth["related"], truth["bent"], truth["discarded"]) == (True, False, [])
    assert (truth["resolution_a"], truth["resolution_b"]) == (a.resolution, b.resolution) == (0.05, 0.06)
    assert truth["overlap"] > 0.3


def test_estimated_poses_are_written_beside_the_true_ones(tmp_path):
    pair = make_pair(LOG, MapSpec(), MapSpec(poses="odometry"), 1)
    write_mission(tmp_path, LOG, pair)

    assert {path.name for path in tmp_path.glob("*.tum")} == {
        *("robot_a.truth.tum", "robot_b.truth.tum", "robot_b.odometry.tum")
    }
    times, true = naive.read_tum(tmp_path / "robot_b.truth.tum")
    _, taken = naive.read_tum(tmp_path / "robot_b.odometry.tum")
    assert np.allclose(times, LOG.b.times)
    assert np.allclose(true[:, :2], LOG.b.poses[:, :2])
    assert np.allclose(taken[:, :2], pair.poses[1][:, :2])
    assert not np.allclose(taken, true)


def test_maps_without_enough_in_common_are_written_without_a_truth(tmp_path):
    pair = replace(
        make_pair(LOG, MapSpec(), MapSpec(), 1),
        related=False,
        pixels=None,
        control_points=None,
        residual_px=None,
        overlap=None,
    )
    write_mission(tmp_path, LOG, pair)
    truth = json.loads((tmp_path / "truth.json").read_text())

    assert [truth[key] for key in ("related", "pixels", "control_points", "overlap")] == [False, None, None, None]


def test_an_earlier_mission_is_refused_or_cleared(tmp_path):
    write_mission(tmp_path, LOG, make_pair(LOG, MapSpec(), MapSpec(poses="odometry"), 1))
    with pytest.raises(InputError, match="--force"):
        write_mission(tmp_path, LOG)
    write_mission(tmp_path, LOG, force=True)

    assert not (tmp_path / "robot_b.odometry.tum").exists()


@pytest.mark.parametrize(
    "corruption", [("turn", 40.0), ("resample", 0.5), ("resample", 1.7), ("bend", 0.2), ("stretch", 0.3)]
)
def test_corrupted_maps_are_written_with_the_cells_and_the_place_that_they_have(tmp_path, corruption):
    spec = MapSpec(corruption=(corruption,), turn_deg=25.0, turn="image")
    pair = make_pair(LOG, spec, spec, 2)
    write_mission(tmp_path, LOG, pair)

    cells = 0.05 / corruption[1] if corruption[0] == "resample" else 0.05
    for name in "ab":
        assert pair.info[f"resolution_{name}"] == pytest.approx(cells)
        assert wall_distance(LOG.world, wall_points(tmp_path / f"robot_{name}.yaml")).mean() < 1.5 * cells


def test_a_pair_that_was_cut_shorter_than_its_log_is_written_with_what_it_was_made_from(tmp_path):
    short = replace(LOG, a=LOG.a.until(float(LOG.a.times[8])), whole=LOG)
    write_mission(tmp_path, LOG, make_pair(short, MapSpec(), MapSpec(), 1))

    assert len(naive.read_tum(tmp_path / "robot_a.truth.tum")[0]) == 9
    assert len(MissionLog.load(tmp_path / "mission.npz").a.times) == 9


def test_maps_of_two_buildings_are_refused_before_anything_is_written(tmp_path):
    pair = make_pair(LOG, MapSpec(), MapSpec(), 1)
    for strange in (replace(pair, poses=None), replace(pair, info={**pair.info, "variant": "mirrored"})):
        with pytest.raises(InputError, match="not of one building"):
            write_mission(tmp_path / "out", LOG, strange)

    assert not (tmp_path / "out").exists()
