import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim.bullet import URDF, physics
from sim.floorplans import Office, make_world
from sim.sensors.ray_casting import ROBOT_PARTS, Caster
from sim.world import Prism, World, bar
from tests.sim import naive
from tests.sim.small_worlds import box_world, glass_world

ANGLES = np.linspace(-3.1, 3.1, 301)
ALONE = np.empty((0, 3))
CYLINDER = r'<collision><origin xyz="0 0 ([\d.]+)"/><geometry><cylinder radius="([\d.]+)" length="([\d.]+)"'


def scattered(seed: int) -> World:
    """Make bars of all sizes and directions, some above and some below a scanner, some of glass."""
    rng = np.random.default_rng(seed)

    def drawn(count: int) -> tuple[Prism, ...]:
        starts, sizes, turns = (
            rng.uniform(0, 9, (count, 2)),
            rng.exponential(1.5, count) + 0.02,
            rng.uniform(0, 7, count),
        )
        ends = starts + (sizes * [np.cos(turns), np.sin(turns)]).T
        heights = rng.choice([0.0, 0.4], count)
        return tuple(Prism(bar(p, q, 0.1), 0.9, z) for p, q, z in zip(starts, ends, heights, strict=True))

    return World(size=(9.0, 9.0), walls=drawn(rng.integers(0, 12)), furniture=drawn(3), glass=drawn(rng.integers(0, 4)))


def circles(others, height: float) -> list[tuple[float, float, float]]:
    (radius,) = (r for bottom, top, r in ROBOT_PARTS if bottom <= height < top)
    return [(x, y, radius) for x, y, _ in others]


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10_000), st.floats(-3, 12), st.floats(-3, 12), st.floats(-9, 9), st.sampled_from([0.12, 0.25, 0.5])
)
def test_buckets_change_nothing(seed, x, y, yaw, height):
    world, pose = scattered(seed), np.array([x, y, yaw])
    others = np.random.default_rng(seed).uniform(0, 9, (2, 3))

    fast = Caster(world, height).cast(pose, ANGLES[::4], 7.0, others)
    slow = naive.ray_hits(world, pose, ANGLES[::4], 7.0, height, circles(others, height))

    for one, other in ((fast.ranges, slow.ranges), (fast.glass, slow.glass)):
        assert np.isclose(one, other, rtol=0, atol=1e-9).mean() > 0.98  # a ray may just graze a corner for one of them


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_rays_along_the_buckets_meet_walls_on_their_rims(yaw):
    wall = Prism(np.array([[2.0, -2.0], [2.4, -2.0], [2.4, 2.0], [2.0, 2.0]]), 1.0)
    world = World(size=(5.0, 5.0), walls=(wall, replace(wall, outline=wall.outline - [4.4, 0.0])))
    ahead = Caster(world, 0.25).cast(np.array([0.0, 0.0, yaw]), np.zeros(1), 5.0, ALONE).ranges[0]

    assert ahead == pytest.approx(2.0) if abs(math.cos(yaw)) > 0.5 else np.isinf(ahead)


def test_nothing_beyond_the_longest_range_is_met():
    world = glass_world().at_visit(0)
    near = Caster(world, 0.25).cast(np.array([1.0, 2.0, 0.0]), ANGLES, 1.2, np.array([[2.5, 2.0, 0.0]]))

    assert near.ranges[np.isfinite(near.ranges)].max() < 1.2
    assert np.isinf(near.glass).all()


def test_an_empty_world_lets_all_rays_pass():
    reading = Caster(World(size=(1.0, 1.0), walls=()), 0.25).cast(np.zeros(3), ANGLES, 9.0, ALONE)

    assert np.isinf(reading.ranges).all()
    assert np.isinf(reading.glass).all()


def test_a_world_of_two_visits_is_refused():
    with pytest.raises(InputError, match="at_visit"):
        Caster(replace(box_world(), visits=(box_world().furniture, ())), 0.25)


def test_the_robots_circles_are_the_cylinders_of_its_description():
    text = URDF.read_text()
    body, mast = (tuple(map(float, match)) for match in re.findall(CYLINDER, text))
    foot = float(re.search(r'mast"/><origin xyz="0 0 ([\d.]+)"', text)[1])

    parts = [(z + base - length / 2, z + base + length / 2, r) for base, (z, r, length) in ((0, body), (foot, mast))]
    assert np.allclose(parts, ROBOT_PARTS)


@pytest.mark.sim
@pytest.mark.parametrize("height", [0.12, 0.25, 0.62])
@pytest.mark.parametrize("world", [make_world(Office(oblique=o), 3 + int(o)) for o in (0.0, 1.0)] + [glass_world()])
def test_both_casters_agree(world, height):
    poses = np.array([[*room.spot, 0.7 * k] for k, room in enumerate(world.rooms)])
    others = poses + np.array([0.5, 0.2, 1.0])
    angles = np.linspace(-math.pi, math.pi, 2000)
    off, casters = [], [Caster(world.at_visit(k), height) for k in (0, 1)]
    for k, (pose, other) in enumerate(zip(poses, others, strict=True)):
        with physics(world) as engine:
            robot = engine.add_robot(pose, visit=k % 2)
            engine.add_robot(other, visit=1 - k % 2)
            seen = engine.cast(robot, angles, 12.0, height)
        cast = casters[k % 2].cast(pose, angles, 12.0, other[None])
        for one, two in ((seen.ranges, cast.ranges), (seen.glass, cast.glass)):
            off.append(np.abs(np.minimum(one, 99.0) - np.minimum(two, 99.0)))

    assert np.median(off) < 1e-6
    assert np.mean(np.array(off) < 0.05) > 0.999


@pytest.mark.sim
def test_both_casters_agree_on_robots_that_have_driven():
    world = glass_world()
    with physics(world) as engine:
        robots = [engine.add_robot(np.array([1.0, 1.5 + k, 0.0]), visit=k) for k in (0, 1)]
        off = []
        for _ in range(20):
            for _ in range(6):
                for robot, turn in zip(robots, (0.3, -0.3), strict=True):
                    engine.drive(robot, 0.6, turn)
                engine.step()
            poses = [engine.pose(robot) for robot in robots]
            for k in (0, 1):
                seen = engine.cast(robots[k], ANGLES, 12.0, 0.25).ranges
                cast = Caster(world.at_visit(k), 0.25).cast(poses[k], ANGLES, 12.0, poses[1 - k][None]).ranges
                off.append(np.abs(seen - cast))

    assert np.median(off) < 1e-6
    assert np.mean(np.array(off) < 0.05) > 0.998
