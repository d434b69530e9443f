import io
import pickle
from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError, SimulationError
from sim.missions.mission_log import MissionLog, RobotLog, cut_to_overlap
from tests.marking import some_slow
from tests.sim.small_worlds import free_cells, office_log, walked_log


def npy() -> bytes:
    """Write a numpy file of another kind."""
    file = io.BytesIO()
    np.save(file, np.zeros(3))
    return file.getvalue()


def walk(*places: tuple[float, float]) -> RobotLog:
    """Make the log of a robot at given places, one a second."""
    poses = np.array([(x, y, 0.0) for x, y in places])
    return RobotLog(times=np.arange(float(len(poses))), poses=poses, odometry=poses, ranges=np.ones((len(poses), 1)))


def test_a_log_survives_a_file_and_a_pickle(tmp_path):
    log = office_log()
    glass = np.where(log.a.ranges > 3, 2.5, np.inf)
    log = replace(log, a=replace(log.a, glass=glass, entered=(0.5,) * len(log.a.rooms)), discarded=("no luck",))
    log.save(tmp_path / "log.npz")
    for again in (MissionLog.load(tmp_path / "log.npz"), pickle.loads(pickle.dumps(log))):
        assert again.world.to_json_dict() == log.world.to_json_dict()
        assert (again.spec, again.seed, again.discarded) == (log.spec, log.seed, log.discarded)
        assert (again.a.rooms, again.a.entered) == (log.a.rooms, log.a.entered)
        assert np.array_equal(again.b.ranges, log.b.ranges)
        assert np.array_equal(again.a.poses, log.a.poses)
        assert np.array_equal(again.a.glass, glass)
        assert again.b.glass is None


@pytest.mark.parametrize("content", [b"no log", b"", b"PK\x03\x04cut off", npy()])
def test_a_file_that_is_no_log_is_refused_by_name(tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)

    with pytest.raises(InputError, match=r"bad\.npz is not a mission log"):
        MissionLog.load(tmp_path / "bad.npz")


def test_a_log_until_a_time_holds_what_happened_by_then():
    log = replace(walk((0, 0), (1, 0), (2, 0), (3, 0)), rooms=("one", "two"), entered=(0.0, 2.0), note="tired")
    cut = log.until(1.5)

    assert cut.times.tolist() == [0.0, 1.0]
    assert len(cut.poses) == len(cut.odometry) == len(cut.ranges) == 2
    assert cut.rooms == ("one",)
    assert cut.note == "cut after 2 s"
    assert log.until(3.0) is log


@pytest.mark.parametrize(
    ("places", "stuck"),
    [
        ([(k, 0) for k in range(9)], 0.0),
        ([(0, 0)] * 5 + [(1, 0)] * 4, 5.0 + 3.0),
        ([(0, 0), (1, 0), (1, 0), (2, 0)], 0.0),  # two seconds are a turn
        ([(0.05 * (k % 2), 0) for k in range(9)], 8.0),
    ],
)
def test_time_without_progress_is_counted_and_noted_when_it_is_much(places, stuck):
    log = walk(*places)

    assert log.stuck_s == stuck
    assert log.with_stuck_noted().note == (f"no progress in {stuck:.0f} of 8 s" if stuck > 1.6 else "")


@pytest.mark.parametrize("wanted", some_slow([0.45, 0.65, 0.85, 1.0], 0.65))
def test_maps_of_a_cut_log_have_the_wanted_overlap(wanted):
    log = walked_log()
    cut = cut_to_overlap(log, wanted)
    a, b = (free_cells(robot, log.spec.a.lidar) for robot in (cut.a, cut.b))

    assert len(a & b) / min(len(a), len(b)) == pytest.approx(wanted, abs=0.05)
    assert min(len(a), len(b)) * 0.05**2 > 35.0


def test_an_overlap_that_cannot_be_had_is_refused_with_what_can():
    with pytest.raises(SimulationError, match=r"an overlap of 0\.1 is out of reach: maps of \d+ and \d+ m2 can only"):
        cut_to_overlap(office_log(), 0.1)
