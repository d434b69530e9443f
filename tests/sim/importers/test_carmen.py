import gzip
import math

import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.importers import read_carmen
from tests.sim.carmen_logs import flaser, odom, office_walk, robotlaser, write_log

WALK = office_walk()
SCAN = "FLASER 4 1.0 2.0 3.0 4.0 {} {} 0 0 0 0 100.5 nohost 0.5\n"
ROBOT = "ROBOTLASER1 0 -1.5 3 {step} 80 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 100.5 nohost 0.5\n"


def log_of(tmp_path, *parts, name="a.log", **options):
    return read_carmen(write_log(tmp_path / name, *parts), **options)


def flasers(count, *, step=0.1, readings="1.0 2.0 3.0 4.0"):
    number = len(readings.split())
    rows = [f"FLASER {number} {readings} {k * step} 0 0 {k * step} 0 0 {k} nohost {k}\n" for k in range(count)]
    return "".join(rows).encode()


@pytest.mark.parametrize("form", [flaser, robotlaser])
def test_a_raw_log_has_odometry_and_no_poses(tmp_path, form):
    log = log_of(tmp_path, form(WALK, is_corrected=False))

    assert log.poses is None
    assert np.allclose(log.odometry, WALK.odometry, atol=1e-6)
    assert np.allclose(log.angles, WALK.angles, atol=1e-6)
    assert np.allclose(log.times[:2], [100.0, 100.25])


@pytest.mark.parametrize("form", [flaser, robotlaser])
def test_a_corrected_log_has_both(tmp_path, form):
    log = log_of(tmp_path, b"PARAM robot_frontlaser_offset 0.2 nohost 0\n", form(WALK, is_corrected=True))
    offset = 0.2 if form is flaser else 0.0

    assert np.allclose(log.poses, WALK.poses, atol=1e-6)
    assert np.allclose(np.hypot(*(log.odometry - WALK.odometry)[:, :2].T), offset, atol=1e-5)


def test_ranges_are_finite_where_something_was_met(tmp_path):
    log = log_of(
        tmp_path, flaser(WALK.replaced(ranges=np.where(WALK.ranges > 4.0, np.inf, WALK.ranges)), is_corrected=True)
    )
    met = WALK.ranges <= 4.0

    assert np.allclose(log.ranges[met], WALK.ranges[met], atol=0.006)
    assert np.isnan(log.ranges[~met]).all()  # 81.83: no reading


@pytest.mark.parametrize("remissions", [None, "0", "2 17 18"])
def test_robotlaser_is_read_with_and_without_remissions(tmp_path, remissions):
    log = log_of(tmp_path, robotlaser(WALK, is_corrected=True, remissions=remissions))

    assert np.allclose(log.poses, WALK.poses, atol=1e-6)
    assert np.allclose(log.times[-1], 100 + 0.25 * (len(WALK.poses) - 1))


def test_where_scans_have_no_odometry_it_is_interpolated_from_odom(tmp_path):
    corrected = flaser(WALK, is_corrected=True, odometry=False)
    raw = flaser(WALK, is_corrected=False, odometry=False)
    between_lines = raw.replace(b"100.250000 nohost", b"100.375000 nohost")

    assert np.allclose(log_of(tmp_path, odom(WALK), raw).odometry, WALK.odometry, atol=1e-6)
    assert np.allclose(log_of(tmp_path, corrected, odom(WALK)).odometry, WALK.odometry, atol=1e-6)
    assert np.allclose(log_of(tmp_path, odom(WALK), corrected).poses, WALK.poses, atol=1e-6)
    halfway = log_of(tmp_path, odom(WALK), between_lines).odometry[1, :2]
    assert np.allclose(halfway, WALK.odometry[1:3, :2].mean(axis=0), atol=1e-6)


def test_junk_line_ends_and_a_last_line_cut_off_do_no_harm(tmp_path):
    plain = flaser(WALK, is_corrected=True)
    strange = plain.replace(b"\n", b"\r\n") + b"\xff\xfe LASER\x00\nODOM\xe9 1\nNEFF 3\n" + plain[-900:-600]
    cut = plain + plain[: plain.index(b"FLASER 181") + 700][plain.index(b"FLASER 181") :]

    for data in (strange, cut):
        assert np.array_equal(log_of(tmp_path, data).poses, log_of(tmp_path, plain).poses)


def test_a_packed_log_is_read_as_it_is(tmp_path):
    packed = log_of(tmp_path, gzip.compress(flaser(WALK, is_corrected=True)), name="a.log.gz")

    assert np.allclose(packed.poses, WALK.poses, atol=1e-6)


def test_of_two_forms_the_first_is_read_and_every_says_how_often(tmp_path):
    both = flaser(WALK, is_corrected=True) + robotlaser(WALK, is_corrected=False)

    assert np.allclose(log_of(tmp_path, both, every=3).poses, WALK.poses[::3], atol=1e-6)


def test_beyond_the_maximum_there_is_no_reading_and_beyond_reach_nothing_near(tmp_path):
    scans = flasers(3, readings="1.0 12.0 49.99 50.0 0.0 nan")
    log = log_of(tmp_path, b"PARAM robot_front_laser_max 50.0 nohost 0\n", scans, reach_m=10.0)

    assert log.max_range_m == 10.0
    assert np.array_equal(log.ranges[0], [1.0, np.inf, np.nan, np.nan, np.nan, np.nan], equal_nan=True)
    assert log_of(tmp_path, scans).ranges[0, 2:4].tolist() == [np.inf, np.inf]  # read up to 80 m, believed to 30


@pytest.mark.parametrize(
    ("count", "params", "first", "last"),
    [
        (180, "", -90, 89),
        (181, "", -90, 90),
        (360, "PARAM laser_front_laser_resolution 1.0", -90, 89.5),
        (361, "", -90, 90),
        (401, "", -50, 50),
        (541, "", -135, 135),
        (91, "", -90, 90),
        (91, "PARAM laser_front_laser_resolution 1.0", -45, 45),
        (91, "PARAM laser_front_laser_fov 270", -135, 135),
    ],
)
def test_flaser_looks_where_its_number_of_readings_says(tmp_path, count, params, first, last):
    log = log_of(tmp_path, f"{params} nohost 0\n".encode(), flasers(2, readings="1.0 " * count))

    assert np.degrees(log.angles[[0, -1]]) == pytest.approx([first, last])
    assert np.ptp(np.diff(log.angles)) < 1e-9


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "no scan in it"),
        ("# CARMEN Logfile\nODOM 0 0 0 0 0 0 1 nohost 1\n", "no scan in it"),
        ("FLASER 4 1.0 2.0 3.0\n", r":1: 'FLASER' has 5 words.* 13 to 15"),
        (SCAN.format(0, 0) + "FLASER four 1 2 3 4\n", ":2: word 2 must be how many numbers follow, got 'four'"),
        ("FLASER\n", ":1: word 2 .* got nothing"),
        ("FLASER 0 0 0 0 0 0 0 1\n", ":1: word 2 .* got '0'"),
        (f"FLASER {'9' * 5000} 1\n", ":1: word 2 must be"),
        ("\n" + SCAN.format("x", 0), ":2: 'x' is not a number; mend"),
        (SCAN.format("nan", 0), ":1: 'nan' is not a finite number"),
        (SCAN.replace("3.0", "3,0").format(0, 0), ":1: '3,0' is not a number"),
        ("FLASER 5 1 2 3 4 0 0 0 0 0 0 1 nohost 1\n", ":1: 'nohost' is not a number"),
        ("FLASER 3 1 2 3 4 0 0 0 0 0 0 1 nohost 1\n", r":1: 'FLASER' has 15 words"),
        (SCAN.format(0, 0) + "FLASER 3 1 2 3 0 0 0 0 0 0 1\n", ":2: a scan of 3 readings after scans of 4 readings"),
        (ROBOT.format(step="0.5") + ROBOT.format(step="1.0"), ":2: a scan of 3 readings from -1.5 rad by 1, .* after"),
        (ROBOT.format(step="4.0"), ":1: 3 readings 229.183 degrees apart are no scan"),
        (ROBOT.format(step="0").replace("-1.5 3 0", "-1.5 0 0"), ":1: 3 readings 0 degrees apart are no scan"),
        (ROBOT.format(step="0.5").replace(" 3 1 2 3 0 ", " 3 1 2 3 9 "), r":1: 'ROBOTLASER1' has 27 words"),
        (SCAN.format(0, 0) + "ODOM 1 2 3\n", ":2: 'ODOM' has 4 words, .* 8 or more"),
        ("PARAM laser_front_laser_resolution 200 h 0\n" + SCAN.format(0, 0), "200 degrees apart go more than once"),
        ("FLASER " + "1 " * 600_000, ":1: longer than 1000000 bytes"),
    ],
)
def test_bad_logs_are_named_with_line_and_remedy(tmp_path, text, complaint):
    with pytest.raises(InputError, match=complaint) as caught:
        log_of(tmp_path, text.encode())

    assert str(caught.value).startswith(str(tmp_path / "a.log"))
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_carmen(tmp_path / "none.log")
    with pytest.raises(InputError, match="cannot be read after line 0"):
        log_of(tmp_path, b"FLASER", name="a.log.gz")
    with pytest.raises(InputError, match="every must be >= 1, got 0"):
        log_of(tmp_path, flasers(2), every=0)
    with pytest.raises(InputError, match="reach_m must be a positive"):
        log_of(tmp_path, flasers(2), reach_m=math.inf)


def test_a_log_that_is_too_large_says_what_helps(tmp_path, monkeypatch):
    monkeypatch.setattr("sim.importers.carmen.MOST_READINGS", 20)

    with pytest.raises(InputError, match=r":6: more than .*\(--every N\)"):
        log_of(tmp_path, flasers(10))
    assert len(log_of(tmp_path, flasers(10), every=2).times) == 5
