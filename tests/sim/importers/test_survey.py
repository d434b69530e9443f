import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.importers import read_carmen
from sim.importers.survey import survey
from tests.sim.carmen_logs import flaser, numbers, office_walk, readings, robotlaser, write_log
from tests.sim.small_worlds import wall_distance

WALK = office_walk()


def log_of(tmp_path, *parts, name="a.log", **options):
    return read_carmen(write_log(tmp_path / name, *parts), **options)


def flasers(count, *, step=0.1, readings="1.0 2.0 3.0 4.0"):
    number = len(readings.split())
    rows = [f"FLASER {number} {readings} {k * step} 0 0 {k * step} 0 0 {k} nohost {k}\n" for k in range(count)]
    return "".join(rows).encode()


@pytest.mark.parametrize("form", [flaser, robotlaser])
def test_the_map_of_a_corrected_log_shows_the_walls_of_the_world(tmp_path, form):
    seen = survey(log_of(tmp_path, form(WALK, is_corrected=True)))
    grid = seen.map(0.05)
    walls = grid.pixel_to_map(np.argwhere(grid.occupied)[:, ::-1].astype(float))
    away = wall_distance(WALK.world, walls)

    assert not seen.is_matched
    assert len(walls) > 1000
    assert away.mean() < 0.03
    assert np.quantile(away, 0.99) < 0.1


@pytest.mark.parametrize("form", [flaser, robotlaser])
def test_a_raw_log_is_laid_down_by_matching_and_better_than_by_its_wheels(tmp_path, form):
    done = []
    seen = survey(log_of(tmp_path, form(WALK, is_corrected=False)), on_scan=done.append)
    off, wheels = (np.hypot(*(poses - WALK.poses)[:, :2].T) for poses in (seen.robot.poses, WALK.odometry))

    assert seen.is_matched
    assert sum(done) == len(WALK.poses)
    assert off.max() < 0.2 < 0.5 < wheels.max()


def test_poses_are_chosen_as_asked(tmp_path):
    raw, corrected = (log_of(tmp_path, flaser(WALK, is_corrected=corrected)) for corrected in (False, True))

    assert np.allclose(survey(raw, poses="log").robot.poses, WALK.odometry, atol=1e-6)
    assert survey(corrected, poses="match").is_matched
    with pytest.raises(InputError, match="auto, log, match, got 'odometry'"):
        survey(raw, poses="odometry")


def test_a_laser_that_looks_to_one_side_is_laid_down_as_it_looks(tmp_path):
    half = WALK.replaced(angles=WALK.angles[:80], ranges=WALK.ranges[:, :80])
    seen = survey(log_of(tmp_path, robotlaser(half, is_corrected=True)))
    grid = seen.map(0.05)
    walls = grid.pixel_to_map(np.argwhere(grid.occupied)[:, ::-1].astype(float))

    assert wall_distance(WALK.world, walls).mean() < 0.03


def test_scans_made_while_standing_are_left_out(tmp_path):
    rows = "".join(
        f"FLASER 181 {readings(WALK.ranges[k])} {numbers(WALK.poses[k])} {numbers(WALK.odometry[k])} {k + j / 9} h 0\n"
        for k in range(20)
        for j in range(4)
    )
    seen = survey(log_of(tmp_path, rows.encode()))

    assert len(seen.robot.times) == 20


def test_a_robot_that_never_moved_has_no_survey(tmp_path):
    with pytest.raises(InputError, match="1 of 20 scans have movement; a map needs 10"):
        survey(log_of(tmp_path, flasers(20, step=0.0)))


def test_a_laser_that_looks_around_more_than_once_loses_the_last_beam(tmp_path):
    row = "ROBOTLASER1 0 -3.141593 6.283185 0.017453293 80 0.01 0 361 {} 0 {x} 0 0 {x} 0 0 0 0 0 0 0 {x} h 0\n"
    rows = "".join(row.format("1.0 " * 361, x=k / 5) for k in range(20))
    seen = survey(log_of(tmp_path, rows.encode()))

    assert (seen.lidar.beams, seen.lidar.fov_deg) == (360, pytest.approx(360.0))
    assert seen.robot.ranges.shape == (20, 360)
