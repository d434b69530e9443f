import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from sim._kernels.tracing import trace_scans
from sim.sensors.lidar import Lidar
from sim.slam.mapping import build_map, growing_maps
from tests.sim import naive
from tests.sim.small_worlds import box_world, office_log, wall_distance

WORLD, LIDAR = box_world(), Lidar(beams=1440)
POSES = np.array([[1.53, 2.07, 0.4], [5.0, 2.5, 2.0], [1.2, 1.0, -1.0]])
RANGES = np.array([naive.cast(WORLD, pose, LIDAR.angles, LIDAR.max_range_m) for pose in POSES])


@settings(deadline=None)
@given(st.integers(0, 10_000))
def test_tracing_agrees_with_cutting_rays_at_the_grid_lines(seed):
    rng = np.random.default_rng(seed)
    starts, ends = rng.uniform(2, 8, (2, 2)), rng.uniform(-3, 13, (2, 5, 2))
    kinds = rng.integers(-1, 2, (2, 5)).astype(np.int8)
    fast = np.zeros((10, 10), dtype=np.float32)
    slow = np.zeros((10, 10))

    trace_scans(starts, ends, kinds, fast, 1.0, -0.4, 8.0)
    for start, scan, kind in zip(starts, ends, kinds, strict=True):
        naive.trace_scan(start, scan, kind, slow, 1.0, -0.4, 8.0)

    assert np.allclose(fast, slow)


@settings(max_examples=20, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-5, 5), st.floats(-5, 5), st.floats(0.03, 0.12))
def test_in_any_frame_and_resolution_the_walls_stand_where_they_are(yaw, x, y, resolution):
    grid = build_map(POSES, LIDAR.angles, RANGES, resolution=resolution, max_range_m=12.0, frame=(x, y, yaw))
    centres = np.argwhere(grid.occupied)[:, ::-1]
    world = Similarity(1.0, yaw, x, y).apply(grid.pixel_to_map(centres))

    assert wall_distance(WORLD, world).max() < 0.7072 * resolution
    assert grid.resolution == resolution


def test_a_map_is_cropped_to_what_is_known():
    known = ~build_map(POSES, LIDAR.angles, RANGES, resolution=0.05, max_range_m=12.0).unknown

    assert known[0].any()
    assert known[-1].any()
    assert known[:, 0].any()
    assert known[:, -1].any()


def test_the_floor_is_free_and_the_inside_of_the_table_unknown():
    grid = build_map(POSES, LIDAR.angles, RANGES, resolution=0.05, max_range_m=12.0)
    u, v = np.rint(grid.map_to_pixel([[1.5, 2.0], [3.5, 1.35]])).astype(int).T

    assert grid.free[v[0], u[0]]
    assert grid.unknown[v[1], u[1]]


def test_lost_beams_say_nothing_and_beams_that_met_nothing_see_as_far_as_the_scanner():
    ranges = np.array([[np.nan, np.inf]])
    grid = build_map(np.zeros((1, 3)), np.array([1.5, 0.0]), ranges, resolution=0.1, max_range_m=2.0)

    assert grid.shape == (1, 20)
    assert grid.free.all()


def test_cells_of_little_evidence_stay_unknown():
    given = {"resolution": 0.1, "max_range_m": 2.0, "miss": 0.4}
    once, twice = (np.zeros((scans, 3)) for scans in (1, 2))
    grids = [
        build_map(poses, np.array([0.0]), np.full((len(poses), 1), np.inf), **given, least_evidence=least)
        for poses, least in ((once, 0.3), (twice, 0.6))
    ]

    assert [int(grid.free.sum()) for grid in grids] == [20, 20]
    with pytest.raises(InputError, match="least_evidence"):
        build_map(once, np.array([0.0]), np.full((1, 1), np.inf), **given, least_evidence=0.6)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"resolution": 0.0}, "resolution"),
        ({"resolution": 1e-5}, "too large"),
        ({"hit": 0.0}, "hit and miss"),
        ({"miss": -0.4}, "hit and miss"),
        ({"hit": 8.5}, "hit and miss"),
        ({"ranges": RANGES[:, :5]}, "disagree"),
        ({"ranges": np.full_like(RANGES, np.nan)}, "no reading"),
        ({"least_evidence": 9.0}, "no cell has more evidence than least_evidence = 9"),
    ],
)
def test_build_map_says_what_is_wrong(changes, complaint):
    values = {"poses": POSES, "angles": LIDAR.angles, "ranges": RANGES, "resolution": 0.05, "max_range_m": 12.0}

    with pytest.raises(InputError, match=complaint):
        build_map(**{**values, **changes})


def test_growing_maps_are_those_of_the_scans_so_far():
    log = office_log()
    robot, lidar = log.a, log.spec.a.lidar
    given = {"resolution": 0.05, "max_range_m": lidar.max_range_m, "frame": (0.3, -0.2, 0.4)}
    ranges = lidar.limit(robot.ranges)
    grown = list(growing_maps(robot.poses, lidar.angles, ranges, [1, 4, len(ranges)], **given))

    for count, grid in zip((1, 4, len(ranges)), grown, strict=True):
        alone = build_map(robot.poses[:count], lidar.angles, ranges[:count], **given)
        assert (grid.occupancy == alone.occupancy).all()
        assert grid.origin == pytest.approx(alone.origin, abs=1e-12)
