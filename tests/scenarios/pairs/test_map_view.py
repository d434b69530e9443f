import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.pairs.cropping import crop_to_known
from scenarios.pairs.map_view import MapSpec, PlacedMap, place_map
from tests.sim.small_worlds import office_log

LOG = office_log()


def placed(poses: np.ndarray | None = None) -> PlacedMap:
    """Robot A's map, made by true poses, that claims to be made by others."""
    made = place_map(LOG.a, LOG.spec.a.lidar, MapSpec(turn_deg=30.0), noise=0, seed=np.random.SeedSequence(1))
    return made if poses is None else replace(made, poses=poses)


def matrix(pose: np.ndarray) -> np.ndarray:
    """The homogeneous matrix from a scanner's own frame to the world."""
    x, y, yaw = pose
    return np.array([[math.cos(yaw), -math.sin(yaw), x], [math.sin(yaw), math.cos(yaw), y], [0.0, 0.0, 1.0]])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000))
def test_a_scan_puts_points_where_its_pose_carries_them(seed):
    rng = np.random.default_rng(seed)
    taken = LOG.a.poses + rng.normal(0, 1, LOG.a.poses.shape)
    points, scans = rng.uniform(0, 10, (8, 2)), rng.integers(0, len(taken), 8)
    carried = [
        (matrix(taken[scan]) @ np.linalg.inv(matrix(LOG.a.poses[scan])) @ [*point, 1.0])[:2]
        for point, scan in zip(points, scans, strict=True)
    ]

    shown = placed(taken).shown_at(points, scans)

    assert np.allclose(shown, placed().world_to_pixel(carried))


def test_true_poses_move_nothing_to_the_bit():
    points, scans = np.random.default_rng(0).uniform(0, 10, (50, 2)), np.arange(50) % len(LOG.a.poses)

    assert np.array_equal(placed().shown_at(points, scans), placed().world_to_pixel(points))


@settings(max_examples=15, deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-50, 50), st.floats(-50, 50), st.floats(0.0, 1.0))
def test_the_error_of_a_trajectory_ignores_where_its_frame_lies(turn, x, y, size):
    error = size * np.random.default_rng(1).normal(0, 1, LOG.a.poses.shape)
    erring = LOG.a.poses + error * [1, 1, 0]
    cos, sin = math.cos(turn), math.sin(turn)
    shifted = np.column_stack([erring[:, :2] @ [[cos, sin], [-sin, cos]] + [x, y], erring[:, 2] + turn])

    assert placed(shifted).ate_m == pytest.approx(placed(erring).ate_m, abs=1e-9)
    assert placed(erring).ate_m <= np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()) + 1e-12


def test_the_error_of_a_stretched_trajectory_is_what_is_left_over():
    stretched = np.column_stack([LOG.a.poses[:, :2] * 1.1, LOG.a.poses[:, 2]])
    about = LOG.a.poses[:, :2] - LOG.a.poses[:, :2].mean(axis=0)

    assert placed(stretched).ate_m == pytest.approx(0.1 * np.sqrt((about**2).sum(axis=1).mean()))


def test_a_mapper_that_trusts_misses_more_keeps_fewer_walls():
    bold, shy = (
        place_map(LOG.a, LOG.spec.a.lidar, MapSpec(hit=0.5, miss=miss), noise=2, seed=np.random.SeedSequence(1)).grid
        for miss in (0.1, 0.5)
    )

    assert shy.occupied.sum() < 0.9 * bold.occupied.sum()


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
        ({"poses": "gps"}, "poses must be one of truth, odometry, slam"),
        ({"loop_closure": True}, "loop_closure needs"),
        ({"loop_closure": True, "poses": "odometry"}, "loop_closure needs"),
        ({"hit": 0.0}, "hit must be"),
        ({"miss": -0.4}, "miss must be"),
        ({"miss": 9.0}, "miss must be"),
    ],
)
def test_a_map_spec_names_the_value_it_refuses(values, complaint):
    with pytest.raises(InputError, match=complaint):
        MapSpec(**values)
