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

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.pairs import make_pair
from scenarios.placement import MapSpec, crop_to_known, place_map
from sim.mission import RobotSpec
from tests.sim.made import office_log, wall_distance

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


def pixel_to_world(placed, pixels):
    """Invert `world_to_pixel`, which is affine, from three points."""
    base = placed.world_to_pixel([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    forward = np.stack([base[1] - base[0], base[2] - base[0]], axis=1)
    return np.linalg.solve(forward, (pixels - base[0]).T).T


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
from tests.scenarios.test_pairs import LOG, MapSpec, make_pair
spec = MapSpec(turn_deg="random", turn="image")
pair = make_pair(LOG, spec, spec, 5, noise=3)
arrays = pair.a.occupancy, pair.b.occupancy, pair.control_points
print(hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest())
"""


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


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 9), st.integers(1, 9))
def test_a_crop_holds_as_many_known_cells_as_any_window_and_keeps_the_frame(seed, width, height):
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(rng.choice([-1, 0], (6, 7), p=[0.7, 0.3]).astype(np.int8), 0.5, (3.0, 4.0, 0.3))
    part = crop_to_known(grid, (width, height))
    padded = np.pad(grid.occupancy, 10, constant_values=-1)
    best = max((padded[r : r + height, c : c + width] >= 0).sum() for r in range(17) for c in range(18))

    assert part.shape == (height, width)
    assert part.free.sum() == best
    for v, u in np.argwhere(part.free):
        old = np.rint(grid.map_to_pixel(part.pixel_to_map([u, v]))).astype(int)
        assert grid.free[old[1], old[0]]


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"resolution": 0.0}, "resolution"),
        ({"turn_deg": float("nan")}, "turn_deg"),
        ({"turn_deg": "left"}, "turn_deg"),
        ({"turn": "both"}, "turn must"),
        ({"canvas": (100, 100)}, "canvas needs"),
        ({"extent_cells": (0, 5), "turn": "image"}, "extent_cells"),
    ],
)
def test_a_map_spec_names_the_value_it_refuses(values, complaint):
    with pytest.raises(InputError, match=complaint):
        MapSpec(**values)
