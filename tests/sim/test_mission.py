import hashlib
import io
import pickle
import subprocess
import sys

import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.floorplans import Office, make_world
from sim.lidar import Lidar
from sim.mission import MissionLog, MissionSpec, RobotSpec, run_mission
from tests.sim import naive
from tests.sim.made import office_log, wall_distance

ROBOT = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=90))
SPEC = MissionSpec(max_seconds=25.0, a=ROBOT, b=ROBOT)
HASH = """
import hashlib
from tests.sim.test_mission import short_mission
log = short_mission()
parts = [getattr(r, k).tobytes() for r in (log.a, log.b) for k in ("times", "poses", "odometry", "ranges")]
print(hashlib.sha256(b"".join(parts)).hexdigest())
"""


def npy() -> bytes:
    """A numpy file of another kind."""
    file = io.BytesIO()
    np.save(file, np.zeros(3))
    return file.getvalue()


def short_mission() -> MissionLog:
    return run_mission(make_world(Office(size_m=(14.0, 10.0), rooms=6), 2), SPEC, 5)


@pytest.fixture(scope="module")
def log():
    return short_mission()


@pytest.mark.sim
def test_the_same_seed_gives_the_same_bytes_in_any_process(log):
    done = subprocess.run([sys.executable, "-c", HASH], capture_output=True, text=True, check=True)
    parts = [getattr(r, k).tobytes() for r in (log.a, log.b) for k in ("times", "poses", "odometry", "ranges")]

    assert done.stdout.strip() == hashlib.sha256(b"".join(parts)).hexdigest()


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
    assert np.hypot(*(log.a.odometry[6] - log.a.poses[6])[:2]) < 0.3


@pytest.mark.sim
def test_a_robot_that_runs_out_of_time_says_so(log):
    assert {log.a.note, log.b.note} == {"out of time after 25 s"}
    assert len(log.a.times) == 50


def test_a_log_survives_a_file_and_a_pickle(tmp_path):
    log = office_log()
    log.save(tmp_path / "log.npz")
    for again in (MissionLog.load(tmp_path / "log.npz"), pickle.loads(pickle.dumps(log))):
        assert again.world.as_dict() == log.world.as_dict()
        assert (again.spec, again.seed, again.b.rooms) == (log.spec, log.seed, log.b.rooms)
        assert np.array_equal(again.b.ranges, log.b.ranges)
        assert np.array_equal(again.a.poses, log.a.poses)


@pytest.mark.parametrize("content", [b"no log", b"", b"PK\x03\x04cut off", npy()])
def test_a_file_that_is_no_log_is_refused_by_name(tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)

    with pytest.raises(InputError, match=r"bad\.npz is not a mission log"):
        MissionLog.load(tmp_path / "bad.npz")


@pytest.mark.parametrize("values", [{"share": 1.2}, {"speed_m_s": 0.0}, {"scan_hz": 100.0}, {"max_seconds": 0.0}])
def test_a_spec_names_the_value_it_refuses(values):
    with pytest.raises(InputError, match=next(iter(values))):
        (MissionSpec if "max_seconds" in values else RobotSpec)(**values)
