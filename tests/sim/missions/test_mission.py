import hashlib
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError, SimulationError
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar
from sim.world import World
from tests.sim import naive
from tests.sim.small_worlds import box_world, free_cells, plain_office, rectangle, wall_distance

ROBOT = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=90))
SPEC = MissionSpec(max_seconds=25.0, a=ROBOT, b=ROBOT)
EXPLORER = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=180), path="frontier")
HASH = """
from tests.sim.missions.test_mission import digest, short_mission
print(digest(short_mission("tour")), digest(short_mission("frontier")))
"""


def short_mission(path: str) -> MissionLog:
    spec = SPEC if path == "tour" else replace(SPEC, a=EXPLORER, b=EXPLORER, rays="compiled")
    return run_mission(small_office(2), spec, 5)


def small_office(seed: int) -> World:
    return plain_office(seed)


def digest(log: MissionLog) -> str:
    parts = [getattr(r, k).tobytes() for r in (log.a, log.b) for k in ("times", "poses", "odometry", "ranges")]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def overlap(log: MissionLog) -> float:
    """Return the overlap of the exact maps of both robots."""
    a, b = (free_cells(robot, spec.lidar) for robot, spec in ((log.a, log.spec.a), (log.b, log.spec.b)))
    return len(a & b) / min(len(a), len(b))


@pytest.fixture(scope="module")
def log():
    return short_mission("tour")


@pytest.mark.sim
def test_the_same_seed_gives_the_same_bytes_in_any_process(log):
    done = subprocess.run([sys.executable, "-c", HASH], capture_output=True, text=True, check=True)

    assert done.stdout.split() == [digest(log), digest(short_mission("frontier"))]


@pytest.mark.sim
def test_robots_drive_and_keep_off_the_walls(log):
    for robot in (log.a, log.b):
        assert np.hypot(*np.diff(robot.poses[:, :2], axis=0).T).sum() > 5.0
        assert wall_distance(log.world, robot.poses[:, :2]).min() > 0.17


@pytest.mark.sim
def test_the_log_keeps_true_ranges_at_true_poses(log):
    for k in (0, len(log.a.times) // 2, -1):
        true = naive.cast(log.world, log.a.poses[k], log.spec.a.lidar.angles, log.spec.a.lidar.max_range_m)
        assert np.isclose(np.minimum(log.a.ranges[k], 99), np.minimum(true, 99), atol=1e-3).mean() > 0.97


@pytest.mark.sim
def test_odometry_starts_at_the_truth_and_follows_it_for_a_while(log):
    assert np.allclose(log.a.odometry[0], log.a.poses[0])
    way_m = np.hypot(*np.diff(log.a.poses[:7, :2], axis=0).T).sum()
    assert np.hypot(*(log.a.odometry[6] - log.a.poses[6])[:2]) < 0.3 * way_m  # wheels slip where a robot spins


@pytest.mark.sim
def test_a_robot_that_runs_out_of_time_says_so(log):
    assert {log.a.note, log.b.note} == {"out of time after 25 s"}
    assert len(log.a.times) == 50


@pytest.mark.sim
def test_the_log_says_which_rooms_a_robot_was_in_and_since_when(log):
    assert log.a.rooms
    assert len(log.a.rooms) == len(log.a.entered)
    assert list(log.a.entered) == sorted(log.a.entered)


@pytest.mark.sim
@pytest.mark.parametrize("rays", ["pybullet", "compiled"])
def test_robots_explore_a_building_without_rooms_and_never_touch(rays):
    office = small_office(3)
    world = replace(office, rooms=(), doors=(), floor=tuple(r.outline for r in (*office.rooms,)))
    floor = (*world.floor, rectangle(0.3, 0.3, 13.7, 9.7))
    log = run_mission(
        replace(world, floor=floor), replace(SPEC, a=EXPLORER, b=EXPLORER, rays=rays, max_seconds=60.0), 1
    )
    apart = log.a.poses[: len(log.b.poses)] - log.b.poses[: len(log.a.poses)]

    assert np.hypot(*apart[:, :2].T).min() > 0.36
    for robot in (log.a, log.b):
        assert len(free_cells(robot, EXPLORER.lidar)) * 0.05**2 > 60
        assert wall_distance(world, robot.poses[:, :2]).min() > 0.17
        assert "stuck" not in robot.note
    assert set(log.seconds) == {"physics", "rays", "planning", "rest"}


@pytest.mark.sim
def test_robots_that_close_their_loops_end_where_they_began():
    tour = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=90), closes_loop=True, share=0.5)
    spec = replace(SPEC, a=tour, b=replace(EXPLORER, closes_loop=True), max_seconds=90.0, rays="compiled")
    log = run_mission(small_office(4), spec, 0)

    for robot in (log.a, log.b):
        assert robot.note == ""
        assert np.hypot(*(robot.poses[-1] - robot.poses[0])[:2]) < 0.8  # arrived, half a second after the last scan
        assert np.hypot(*(robot.poses - robot.poses[0])[:, :2].T).max() > 3.0


@pytest.mark.sim
@pytest.mark.parametrize(("path", "wanted"), [("tour", 0.5), ("frontier", 0.8), ("frontier", 0.3)])
def test_maps_have_the_wanted_overlap_within_a_twentieth(path, wanted):
    robot = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=360), path=path)
    world = plain_office(2, size_m=(20.0, 13.0), rooms=8)
    log = run_mission(world, MissionSpec(a=robot, b=robot, overlap=wanted, rays="compiled", max_seconds=120.0), 0)

    assert overlap(log) == pytest.approx(wanted, abs=0.05)


@pytest.mark.sim
def test_an_overlap_out_of_reach_is_said_after_the_tries_with_what_was_reached():
    with pytest.raises(SimulationError, match=r"no mission in 2 tries: an overlap of 0\.2 is out of reach: .* cut to"):
        run_mission(box_world(7.0, 7.0), replace(SPEC, a=EXPLORER, b=EXPLORER, overlap=0.2, tries=2), 0)


@pytest.mark.sim
def test_tries_that_came_to_nothing_are_counted_in_the_log(monkeypatch):
    answers = [SimulationError("too little"), SimulationError("too much")]

    def cut(log: MissionLog, wanted: float) -> MissionLog:
        if answers:
            raise answers.pop(0)
        return log

    monkeypatch.setattr("sim.missions.mission.cut_to_overlap", cut)
    log = run_mission(small_office(2), replace(SPEC, overlap=0.5, max_seconds=10.0, rays="compiled"), 3)

    assert log.discarded == ("too little", "too much")
    assert log.seed == 3


@pytest.mark.sim
def test_a_robot_ends_when_it_has_seen_the_wanted_share_of_the_floor():
    spec = replace(SPEC, a=EXPLORER, b=EXPLORER, coverage=0.4, rays="compiled", max_seconds=100.0)
    some = run_mission(small_office(2), spec, 0)
    rest = run_mission(small_office(2), replace(spec, coverage=0.9), 0)

    assert (some.a.note, some.b.note) == ("", "")
    assert some.a.times[-1] < rest.a.times[-1]


@pytest.mark.sim
@pytest.mark.parametrize(
    ("world", "robot", "complaint"),
    [
        (World(size=(5.0, 5.0), walls=()), ROBOT, "no floor"),
        (box_world(0.8, 0.7), ROBOT, "fits nowhere in this box"),
        (replace(box_world(), rooms=(), floor=(rectangle(0, 0, 6, 4),)), ROBOT, "no rooms to tour"),
        (box_world(1.5, 1.2), ROBOT, "no place for another robot"),
    ],
)
def test_a_world_that_cannot_be_explored_is_refused_in_a_clear_line(world, robot, complaint):
    with pytest.raises(SimulationError, match=complaint):
        run_mission(world, replace(SPEC, a=robot, b=robot), 0)


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (RobotSpec, {"share": 1.2}),
        (RobotSpec, {"speed_m_s": 0.0}),
        (RobotSpec, {"scan_hz": 100.0}),
        (RobotSpec, {"scan_hz": 12.0}),
        (RobotSpec, {"path": "spiral"}),
        (RobotSpec, {"share": 0.5, "path": "frontier"}),
        (MissionSpec, {"max_seconds": 0.0}),
        (MissionSpec, {"overlap": 0.05}),
        (MissionSpec, {"coverage": 1.5}),
        (MissionSpec, {"rays": "x"}),
        (MissionSpec, {"tries": 0}),
        (MissionSpec, {"overlap": 0.5, "a": RobotSpec(share=0.7)}),
    ],
)
def test_a_spec_names_the_value_it_refuses(kind, values):
    with pytest.raises(InputError, match=next(iter(values))):
        kind(**values)


@pytest.mark.sim
@pytest.mark.parametrize(("asked", "kept"), [(10.0, 10.0), (7.0, 60 / 9), (8.0, 7.5)])
def test_scans_are_never_made_more_often_than_asked_for(asked, kept):
    robot = RobotSpec(scan_hz=asked, lidar=Lidar(beams=30))
    log = run_mission(small_office(2), MissionSpec(a=robot, b=robot, max_seconds=6.0, rays="compiled"), 1)

    assert 1 / np.diff(log.a.times).mean() == pytest.approx(kept, rel=0.01)
