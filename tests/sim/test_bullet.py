import subprocess
import sys

import numpy as np
import pytest

from rectmerge.errors import InputError, SimulationError
from sim import bullet
from sim.bullet import MOST_RAYS, mesh, physics
from sim.floorplans import WorldSpec, make_world
from tests.sim import naive
from tests.sim.made import box_world


@pytest.mark.sim
def test_rays_meet_what_the_plan_says():
    world = make_world(WorldSpec(oblique=1.0), 3)
    angles = np.linspace(-3.1, 3.1, 500)
    with physics(world) as engine:
        poses = [np.array([*room.spot, 0.7]) for room in world.rooms]
        robots = [engine.add_robot(pose) for pose in poses]
        for robot, pose in zip(robots, poses, strict=True):
            seen, true = engine.cast(robot, angles, 8.0, 0.25).ranges, naive.cast(world, pose, angles, 8.0)
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
    code = "from sim.bullet import physics; from tests.sim.made import box_world\nwith physics(box_world()): pass"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stderr == ""
    assert done.stdout == ""


def test_without_pybullet_the_remedy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pybullet", None)
    bullet._pybullet.cache_clear()
    try:
        with pytest.raises(SimulationError, match=r"pip install rectmerge\[sim\]"), physics(box_world()):
            pass
    finally:
        bullet._pybullet.cache_clear()


def test_a_mesh_has_the_volume_of_its_prisms():
    world = box_world()
    vertices, triangles = mesh(world.furniture)
    corners = vertices[triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6

    assert volume == pytest.approx(1.0 * 0.7 * 0.75)  # the bottom lies at z = 0 and adds nothing
