import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError, SimulationError
from sim import bullet
from sim.bullet import MOST_RAYS, Physics, physics
from sim.floorplans import Office, make_world
from sim.world import Prism
from tests.sim import naive
from tests.sim.small_worlds import box_world, glass_world


def drive(engine: Physics, steps: int, *robots: tuple[int, float]) -> None:
    """Let robots drive straight on at their speeds."""
    for _ in range(steps):
        for robot, speed in robots:
            engine.drive(robot, speed, 0.0)
        engine.step()


@pytest.mark.sim
def test_rays_meet_what_the_plan_says():
    world = make_world(Office(oblique=1.0), 3)
    angles = np.linspace(-3.1, 3.1, 500)
    with physics(world) as engine:
        poses = [np.array([*room.spot, 0.7]) for room in world.rooms]
        robots = [engine.add_robot(pose) for pose in poses]
        for robot, pose in zip(robots, poses, strict=True):
            seen = engine.cast(robot, angles, 8.0, 0.25).ranges
            true = naive.ray_hits(world.at_visit(0), pose, angles, 8.0, 0.25).ranges
            same = np.isclose(np.minimum(seen, 9.0), np.minimum(true, 9.0), atol=1e-4)
            assert same.mean() > 0.995  # a ray may slip past an edge that another just meets


@pytest.mark.sim
def test_more_rays_than_one_batch_holds_all_come_back():
    world = box_world()
    angles = np.linspace(-3, 3, 2 * MOST_RAYS + 5)
    with physics(world) as engine:
        robot = engine.add_robot(np.array([1.5, 2.0, 0.0]))
        assert np.isfinite(engine.cast(robot, angles, 20.0, 0.25).ranges).all()


@pytest.mark.sim
def test_a_robot_drives_as_its_wheels_turn_and_walls_stop_it():
    with physics(box_world()) as engine:
        robot = engine.add_robot(np.array([1.0, 2.5, 0.0]))
        for _ in range(120):
            engine.drive(robot, 0.5, 0.0)
            engine.step()
        assert engine.pose(robot) == pytest.approx([2.0, 2.5, 0.0], abs=0.05)
        assert engine.wheel_angles(robot)[0] == pytest.approx(1.0 / bullet.WHEEL_RADIUS_M, rel=0.03)
        for _ in range(1200):
            engine.drive(robot, 0.5, 0.0)
            engine.step()
        assert 5.0 < engine.pose(robot)[0] < 5.8 - 0.16


@pytest.mark.sim
def test_a_robot_turns_left_for_a_positive_rate():
    with physics(box_world()) as engine:
        robot = engine.add_robot(np.array([1.5, 2.5, 0.0]))
        for _ in range(60):
            engine.drive(robot, 0.0, 1.0)
            engine.step()
        assert engine.pose(robot)[2] == pytest.approx(1.0, abs=0.1)


@pytest.mark.sim
@pytest.mark.parametrize("height", [0.1, 0.25, 0.6])
def test_robots_see_each_other_and_never_themselves(height):
    with physics(box_world()) as engine:
        near = engine.add_robot(np.array([1.0, 2.5, 0.0]))
        far = engine.add_robot(np.array([2.0, 2.5, np.pi]), visit=1)
        radius = 0.17 if height < 0.17 else 0.1
        for robot in (near, far):
            seen = engine.cast(robot, np.array([0.0, np.pi]), 9.0, height).ranges
            assert seen[0] == pytest.approx(1.0 - radius, abs=1e-3)
            assert seen[1] > 0.75  # the wall behind it, not its own body


@pytest.mark.sim
def test_each_visit_meets_its_own_things_only():
    world = glass_world()  # A's crate lies to the right of the robots, B's to the left
    with physics(world) as engine:
        for visit in (0, 1):
            robot = engine.add_robot(np.array([2.4, 2.0, 0.0]), visit=visit)
            right, left = engine.cast(robot, np.array([-np.pi / 2, np.pi / 2]), 9.0, 0.25).ranges
            assert (right, left) == pytest.approx((1.2, 1.8) if visit == 0 else (1.8, 1.0), abs=1e-6)


@pytest.mark.sim
@pytest.mark.parametrize(("visit", "stops_at"), [(0, 0.8 + 0.19), (1, 0.2 + 0.19)])
def test_the_other_visits_things_stop_nobody(visit, stops_at):
    with physics(glass_world()) as engine:
        robot = engine.add_robot(np.array([2.4, 1.6, -np.pi / 2]), visit=visit)
        drive(engine, 300, (robot, 0.5))
        assert engine.pose(robot)[1] == pytest.approx(stops_at, abs=0.03)


@pytest.mark.sim
def test_glass_stops_robots_but_no_ray():
    with physics(glass_world()) as engine:
        robot = engine.add_robot(np.array([3.8, 2.5, 0.0]))
        ahead = engine.cast(robot, np.array([0.0, 1.3]), 9.0, 0.25)
        assert ahead.ranges[0] == pytest.approx(5.8 - 3.8, abs=1e-6)
        assert ahead.glass[0] == pytest.approx(4.6 - 3.8, abs=1e-6)
        assert np.isinf(ahead.glass[1])  # a wall is nearer than the pane
        drive(engine, 300, (robot, 0.5))
        assert 4.2 < engine.pose(robot)[0] < 4.6 - 0.15


@pytest.mark.sim
def test_robots_stop_each_other_and_stay_upright():
    with physics(box_world()) as engine:
        one = engine.add_robot(np.array([1.0, 2.5, 0.0]))
        other = engine.add_robot(np.array([2.5, 2.5, np.pi]), visit=1)
        for _ in range(100):
            drive(engine, 3, (one, 0.8), (other, 0.8))
            assert (
                np.hypot(*(engine.pose(other)[:2] - engine.pose(one)[:2])) > 0.3
            )  # bodies give way a little when they meet
        for robot in (one, other):
            turn = engine._bullet.getBasePositionAndOrientation(robot, physicsClientId=engine._client)[1]
            assert np.abs(engine._bullet.getEulerFromQuaternion(turn)[:2]).max() < 0.03


@pytest.mark.sim
def test_the_mast_pushes_nothing():
    shelf = Prism(np.array([[3.0, 0.2], [3.5, 0.2], [3.5, 3.8], [3.0, 3.8]]), 1.0, bottom=0.4)
    with physics(replace(box_world(), furniture=(shelf,))) as engine:
        robot = engine.add_robot(np.array([2.0, 2.0, 0.0]))
        drive(engine, 360, (robot, 0.5))
        assert engine.pose(robot)[0] > 4.0


@pytest.mark.sim
def test_a_robot_without_a_place_is_refused():
    with physics(box_world()) as engine:
        with pytest.raises(InputError, match="visit 2"):
            engine.add_robot(np.zeros(3), visit=2)
        for k in range(bullet.MOST_ROBOTS):
            engine.add_robot(np.array([0.3 * k, 8.0, 0.0]))
        with pytest.raises(InputError, match="16 places"):
            engine.add_robot(np.zeros(3))


@pytest.mark.sim
def test_the_camera_shows_glass_and_what_only_one_visit_finds():
    world = glass_world()
    pictures = []
    for shown in (world, replace(world, glass=()), replace(world, visits=((), world.visits[1]))):
        with physics(shown) as engine:
            pictures.append(engine.camera(160, 120).astype(int))

    for without in pictures[1:]:
        assert np.abs(pictures[0] - without).max() > 20


@pytest.mark.sim
def test_the_camera_sees_floor_walls_and_furniture():
    with physics(box_world()) as engine:
        picture = engine.camera(160, 120)

        assert picture.shape == (120, 160, 3)
        assert picture.dtype == np.uint8
        assert len(np.unique(picture.reshape(-1, 3) // 32, axis=0)) >= 4
        with pytest.raises(InputError, match="picture"):
            engine.camera(0, 100)


@pytest.mark.sim
def test_importing_the_engine_leaves_the_error_stream_clean():
    code = (
        "from sim.bullet import physics; from tests.sim.small_worlds import box_world\nwith physics(box_world()): pass"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stderr == ""
    assert done.stdout == ""


def test_without_pybullet_the_remedy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pybullet", None)
    bullet._pybullet.cache_clear()
    try:
        with pytest.raises(SimulationError, match=r"pip install 'rectmerge\[sim\]'"), physics(box_world()):
            pass
    finally:
        bullet._pybullet.cache_clear()
