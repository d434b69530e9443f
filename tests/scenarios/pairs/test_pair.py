import math
import os
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.similarity import Similarity
from scenarios.pairs.map_view import MapSpec, place_map
from scenarios.pairs.pair import make_pair
from scenarios.pairs.truth import known_extent
from sim.missions.spec import RobotSpec
from tests.scenarios.known_answers import pixel_to_world
from tests.sim.small_worlds import office_log, wall_distance

LOG = office_log()
ENDS = ((LOG.a, slice(0, 3)), (LOG.b, slice(-3, None)))  # three scans in the first room, three in the last
turns = st.floats(-180.0, 180.0)
resolutions = st.floats(0.04, 0.1)
kinds = st.sampled_from(["frame", "image"])


def wall_pixels(grid):
    return np.argwhere(grid.occupied)[:, ::-1].astype(float)


def to_nearest(points, targets):
    """The vectors (N, 2) from points to their nearest targets."""
    away = targets[None] - points[:, None]
    return away[np.arange(len(points)), np.argmin((away**2).sum(axis=-1), axis=1)]


@settings(max_examples=12, deadline=None)
@given(kinds, turns, resolutions)
def test_wall_cells_stand_on_the_walls_of_the_world(kind, turn, resolution):
    spec = MapSpec(resolution=resolution, turn_deg=turn, turn=kind)
    placed = place_map(LOG.a, LOG.spec.a.lidar, spec, noise=0, seed=np.random.SeedSequence(1))
    cells = wall_pixels(placed.grid)
    world = pixel_to_world(placed, cells)

    half = 0.5 if kind == "frame" else 1.0  # half a cell to its centre; the nearest neighbour may be half a cell off
    assert wall_distance(LOG.world, world).max() < 1.4143 * half * resolution
    assert wall_distance(LOG.world, world).mean() < half * resolution


@settings(max_examples=15, deadline=None)
@given(kinds, turns, resolutions, kinds, turns, resolutions)
def test_walls_of_b_mapped_by_the_truth_land_on_walls_of_a(kind_a, turn_a, res_a, kind_b, turn_b, res_b):
    spec_a, spec_b = (
        MapSpec(resolution=res_a, turn_deg=turn_a, turn=kind_a),
        MapSpec(resolution=res_b, turn_deg=turn_b, turn=kind_b),
    )
    pair = make_pair(LOG, spec_a, spec_b, 3)
    share, away = common_walls(pair)

    assert share > 0.4
    bias = np.abs(away.mean(axis=0)).max() / max(1.0, pair.pixels.scale)
    assert bias < 0.75  # where the grids are parallel, each rounds by up to half a cell


def common_walls(pair):
    """Which share of B's wall cells has a wall of A beside it under the truth, and the vectors to that."""
    mapped = pair.pixels.apply(wall_pixels(pair.b))[::7]
    away = to_nearest(mapped, wall_pixels(pair.a))
    near = np.hypot(*away.T) < 1.5 * max(1.0, pair.pixels.scale)
    return near.mean(), away[near]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["frame", "image"])
@pytest.mark.parametrize("turn", [0.0, 33.0, 180.0])
def test_over_many_grid_phases_the_truth_is_biased_to_no_side(kind, turn):
    spec_a, spec_b = MapSpec(turn_deg=10.0), MapSpec(resolution=0.06, turn_deg=turn, turn=kind)
    means = [common_walls(make_pair(LOG, spec_a, spec_b, seed))[1].mean(axis=0) for seed in range(6)]

    assert np.abs(np.mean(means, axis=0)).max() < 0.15  # a pixel's corner taken for its centre would show as 0.5


@settings(max_examples=15, deadline=None)
@given(kinds, turns, turns, resolutions)
def test_the_truth_has_the_scale_and_the_turn_that_were_asked_for(kind, turn_a, turn_b, resolution):
    spec_a = MapSpec(resolution=0.06, turn_deg=turn_a, turn=kind)
    spec_b = MapSpec(resolution=resolution, turn_deg=turn_b, turn="image")
    pair = make_pair(LOG, spec_a, spec_b, 3)

    assert pair.pixels.scale == pytest.approx(resolution / 0.06, rel=1e-9)
    turned = math.radians(turn_b - turn_a)  # b_to_a in pixels, v down: undoing B's turn is clockwise to the eye
    assert abs(math.remainder(pair.pixels.angle - turned, math.tau)) < 1e-9
    assert pair.residual_px < 1e-9
    assert 20 <= len(pair.control_points) <= 400


def test_control_points_lie_on_walls_of_both_maps():
    pair = make_pair(LOG, MapSpec(turn_deg=20.0, turn="image"), MapSpec(resolution=0.06, turn_deg=-50.0), 0)
    for grid, points in ((pair.a, pair.control_points[:, :2]), (pair.b, pair.control_points[:, 2:])):
        away = to_nearest(points, wall_pixels(grid))
        assert np.hypot(*away.T).max() < 2.2
        assert np.abs(away.mean(axis=0)).max() < 0.15


def test_the_same_seed_gives_the_same_pair_and_turns_do_not_depend_on_the_noise():
    spec = MapSpec(turn_deg="random", turn="image")
    first, again, noisy, other = (
        make_pair(LOG, spec, spec, seed, noise=n) for seed, n in ((5, 1), (5, 1), (5, 0), (6, 1))
    )

    assert np.array_equal(first.a.occupancy, again.a.occupancy)
    assert np.array_equal(first.control_points, again.control_points)
    assert first.info["turn_a_deg"] == noisy.info["turn_a_deg"] != other.info["turn_a_deg"]
    assert first.info["turn_a_deg"] != first.info["turn_b_deg"]


BYTES = """
import hashlib
from tests.scenarios.pairs.test_pair import LOG, MapSpec, make_pair
spec = MapSpec(turn_deg="random", turn="image")
pair = make_pair(LOG, spec, spec, 5, noise=3)
arrays = pair.a.occupancy, pair.b.occupancy, pair.control_points
print(hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest())
"""


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_in_any_process(capsys):
    exec(BYTES, {})
    environment = os.environ | {"PYTHONHASHSEED": "7"}
    done = subprocess.run([sys.executable, "-c", BYTES], capture_output=True, text=True, check=True, env=environment)

    assert done.stdout == capsys.readouterr().out


def test_noise_roughens_the_maps_but_not_the_truth():
    spec_a, spec_b = MapSpec(), MapSpec(resolution=0.06, turn_deg=30.0)
    exact, noisy = (make_pair(LOG, spec_a, spec_b, 1, noise=n) for n in (0, 1))

    assert noisy.a.occupied.sum() > 1.2 * exact.a.occupied.sum()
    assert noisy.pixels.scale == pytest.approx(exact.pixels.scale)
    assert noisy.pixels.angle == pytest.approx(exact.pixels.angle)


def test_the_overlap_is_that_of_the_rooms_both_robots_saw():
    whole = make_pair(LOG, MapSpec(), MapSpec(), 1).overlap

    assert 0.3 < whole < 1.0


def test_a_hidden_resolution_is_absent_and_a_known_one_right():
    hidden = make_pair(LOG, MapSpec(), MapSpec(resolution=0.08, hide_resolution=False), 1)

    assert hidden.a.resolution is None
    assert hidden.b.resolution == 0.08
    assert (hidden.info["resolution_a"], hidden.info["resolution_b"]) == (0.05, 0.08)


def test_maps_of_different_ends_of_the_building_are_unrelated():
    a, b = (replace(robot, poses=robot.poses[part], ranges=robot.ranges[part]) for robot, part in ENDS)
    robot = RobotSpec(lidar=replace(LOG.spec.a.lidar, max_range_m=3.0))
    near = replace(LOG.spec, a=robot, b=robot)
    pair = make_pair(replace(LOG, spec=near, a=a, b=b), MapSpec(), MapSpec(), 2)

    assert (pair.related, pair.pixels, pair.control_points, pair.residual_px, pair.overlap) == (False, *[None] * 4)


def test_a_pair_is_picklable():
    pair = make_pair(LOG, MapSpec(), MapSpec(), 1)

    assert pickle.loads(pickle.dumps(pair)).pixels == pair.pixels


def poses_by(motion):
    """Stand in for the robots' own estimates: the true poses moved by a function."""
    return lambda source, *, poses, **_: motion(poses.copy())


def turned_whole(poses):
    """Every pose moved by the same rigid motion."""
    placed = Similarity(1.0, 0.7, 2.0, -1.0)
    return np.column_stack([placed.apply(poses[:, :2]), poses[:, 2] + 0.7])


def turned_from_the_middle_on(poses):
    """The later half of the poses turned by 12 degrees about where the first of them is, as at a lost heading."""
    half = len(poses) // 2
    about = Similarity(1.0, math.radians(12.0))
    poses[half:, :2] = about.apply(poses[half:, :2] - poses[half, :2]) + poses[half, :2]
    poses[half:, 2] += math.radians(12.0)
    return poses


SLAM = MapSpec(poses="slam", turn_deg=15.0)


def test_a_map_that_is_wrong_as_a_whole_is_rigid(monkeypatch):
    monkeypatch.setattr("scenarios.pairs.map_view.estimate_poses", poses_by(turned_whole))
    pair = make_pair(LOG, MapSpec(), SLAM, 3)
    share, away = common_walls(pair)

    assert pair.residual_px < 1e-9
    assert (pair.info["ate_a_m"], pair.info["ate_b_m"]) == (pytest.approx(0, abs=1e-9), pytest.approx(0, abs=1e-9))
    assert not pair.info["bent"]
    assert share > 0.4
    assert np.abs(away.mean(axis=0)).max() < 0.75


def test_a_map_that_lost_its_heading_is_bent_and_its_walls_are_where_the_control_points_say(monkeypatch):
    straight = make_pair(LOG, MapSpec(), MapSpec(), 3)
    monkeypatch.setattr("scenarios.pairs.map_view.estimate_poses", poses_by(turned_from_the_middle_on))
    pair = make_pair(LOG, MapSpec(), SLAM, 3)

    assert pair.info["bent"]
    assert pair.residual_px > 0.015 * known_extent(pair.a)
    assert pair.info["ate_b_m"] > 0.1
    assert not straight.info["bent"]
    for grid, points in ((pair.a, pair.control_points[:, :2]), (pair.b, pair.control_points[:, 2:])):
        away = to_nearest(points, wall_pixels(grid))
        assert np.hypot(*away.T).max() < 2.2
        assert np.abs(away.mean(axis=0)).max() < 0.2


def test_a_pair_says_where_its_poses_come_from_and_wheels_drift():
    rigid, mixed = (make_pair(LOG, MapSpec(), MapSpec(poses=poses), 3) for poses in ("truth", "odometry"))

    assert [rigid.info[f"pose_source{which}"] for which in ("", "_a", "_b")] == ["truth"] * 3
    assert [mixed.info[f"pose_source{which}"] for which in ("", "_a", "_b")] == ["truth/odometry", "truth", "odometry"]
    assert mixed.info["ate_a_m"] == 0.0 < mixed.info["ate_b_m"]
    assert mixed.residual_px > 0.1 > rigid.residual_px
    assert np.array_equal(mixed.a.occupancy, rigid.a.occupancy)


def test_the_wheels_err_alike_at_every_noise_level():
    placed = [
        place_map(LOG.a, LOG.spec.a.lidar, MapSpec(poses="odometry"), noise=noise, seed=np.random.SeedSequence(1))
        for noise in (0, 2)
    ]

    assert np.array_equal(placed[0].poses, placed[1].poses)
    assert not np.array_equal(placed[0].poses, placed[0].true_poses)
