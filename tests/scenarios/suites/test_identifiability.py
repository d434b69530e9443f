import functools
import itertools
from dataclasses import replace

import numpy as np
import pytest

from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.suites.identifiability import LEAST_MARGIN, identifiable_margin
from sim.missions.mission_log import MissionLog, RobotLog
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar
from sim.sensors.ray_casting import Caster
from sim.world import Prism, Room, World

LIDAR = Lidar(beams=720)
UPRIGHT = MapSpec()
DEEP_M, THICK_M = 4.0, 0.1
ALIKE, UNLIKE = (3.0,) * 8, (3.0, 4.1, 2.2, 3.6, 2.7, 4.6, 3.2, 2.4)


def box(x, y, width, height):
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])


@functools.cache
def row_of_cells(widths, seen_a=range(4), seen_b=range(2, 6)):
    """Closed cells in a row, each with a pillar, and two robots that stood in some of them."""
    edges = [0.0, *itertools.accumulate(widths)]
    long = edges[-1] + THICK_M
    walls = [box(edge, 0.0, THICK_M, DEEP_M) for edge in edges]
    walls += [box(0.0, 0.0, long, THICK_M), box(0.0, DEEP_M - THICK_M, long, THICK_M)]
    walls += [box(edge + 0.5, 2.9, 0.4, 0.4) for edge in edges[:-1]]
    rooms = tuple(
        Room(str(k), box(edge, 0.0, width, DEEP_M), np.array([edge + 1.2, 1.5]))
        for k, (edge, width) in enumerate(zip(edges[:-1], widths, strict=True))
    )
    world = World(size=(long, DEEP_M), walls=tuple(Prism(outline, 2.5) for outline in walls), rooms=rooms)
    spec = MissionSpec(a=RobotSpec(lidar=LIDAR), b=RobotSpec(lidar=LIDAR))
    a, b = (standing(world, [rooms[k] for k in seen]) for seen in (seen_a, seen_b))
    return MissionLog(world=world, spec=spec, seed=0, a=a, b=b)


def standing(world, rooms):
    caster = Caster(world, LIDAR.height_m)
    spots = [room.spot + aside for room in rooms for aside in ((0.0, 0.0), (-0.4, 0.9), (0.5, 0.8))]
    poses = np.array([[*spot, 0.1] for spot in spots])
    ranges = [caster.cast(pose, LIDAR.angles, LIDAR.max_range_m, np.empty((0, 3))).ranges for pose in poses]
    return RobotLog(times=np.arange(float(len(poses))), poses=poses, odometry=poses, ranges=np.array(ranges))


def margin(log, spec_a=UPRIGHT, spec_b=UPRIGHT, **how):
    return identifiable_margin(log, make_pair(log, spec_a, spec_b, 1, **how))


def test_identical_cells_in_a_row_cannot_be_told_apart():
    assert margin(row_of_cells(ALIKE)) <= 0.0


def test_cells_of_different_widths_can():
    assert margin(row_of_cells(UNLIKE)) >= LEAST_MARGIN


def test_the_end_of_the_row_does_not_tell_where_it_is_not_seen_by_both():
    both_ends = row_of_cells(ALIKE, range(8), range(8))

    assert margin(both_ends) > margin(row_of_cells(ALIKE, range(8), range(1, 5)))


def test_neither_noise_nor_wrong_poses_nor_turns_nor_cells_change_the_margin():
    log = row_of_cells(UNLIKE)
    lost = replace(log, a=replace(log.a, odometry=log.a.odometry + np.array([3.0, 1.0, 0.4])))
    turned = MapSpec(resolution=0.07, turn_deg=-100.0)
    margins = [margin(lost), margin(lost, noise=2), margin(lost, turned), margin(lost, MapSpec(poses="odometry"))]

    assert len(set(margins)) == 1


def test_a_map_cut_to_a_size_tells_only_what_is_in_it():
    log = row_of_cells((3.0, 3.0, 3.0, 3.0, 3.0, 4.5), range(6), range(6))
    cut = MapSpec(turn="image", extent_cells=(160, 100))  # 8 of 19.6 metres

    assert margin(log, UPRIGHT, MapSpec(turn="image")) >= LEAST_MARGIN > margin(log, UPRIGHT, cut)


@pytest.mark.parametrize("widths", [ALIKE, UNLIKE])
def test_swapping_the_maps_changes_little(widths):
    there, back = row_of_cells(widths), row_of_cells(widths, range(2, 6), range(4))

    assert margin(there) == pytest.approx(margin(back), abs=0.05)
