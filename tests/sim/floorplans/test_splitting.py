import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import SimulationError
from sim.floorplans.drafting import Pen
from sim.floorplans.shapes import disc, rectangle
from sim.floorplans.splitting import Split, area, cut_convex, draw_split, split, width
from sim.world import Prism, covers


@given(st.integers(3, 9), st.floats(0.0, 6.28), st.floats(-3.0, 3.0))
def test_a_cut_parts_a_convex_outline_into_two(corners, angle, at):
    outline = disc([0.5, -0.2], 2.0, corners)
    direction = np.array([np.cos(angle), np.sin(angle)])
    parts = cut_convex(outline, direction, at)
    if parts is None:
        away = outline @ [direction[1], -direction[0]] - at
        assert (away >= -1e-9).all() or (away <= 1e-9).all()
        return
    right, left, line = parts

    assert area(right) + area(left) == pytest.approx(area(outline))
    assert min(area(right), area(left)) >= 0
    assert np.allclose(line @ [direction[1], -direction[0]], at)


@given(st.integers(0, 1000), st.integers(2, 7), st.sampled_from([0.0, 0.7]))
def test_a_split_floor_is_tiled_by_wide_enough_convex_rooms(seed, count, oblique):
    floor = Split([rectangle(0.0, 0.0, 20.0, 14.0)], [])
    split(floor, count, 2.4, np.random.default_rng(seed), oblique=oblique)

    assert len(floor.pieces) == count == len(floor.lines) + 1
    assert sum(map(area, floor.pieces)) == pytest.approx(280.0)
    for piece in floor.pieces:
        Prism(piece, 1.0)  # refuses what is not convex and counter-clockwise
        assert width(piece) >= 2.4


def test_the_width_of_an_outline_is_its_least_extent_in_any_direction():
    outline = np.array([[0.0, 0.0], [6.0, 1.0], [5.0, 4.0], [1.0, 3.5]])
    angles = np.linspace(0.0, np.pi, 20001)
    extents = np.ptp(outline @ np.stack([np.cos(angles), np.sin(angles)]), axis=0)

    assert width(outline) == pytest.approx(extents.min(), abs=1e-3)


def test_a_floor_too_small_to_split_is_refused():
    with pytest.raises(SimulationError, match="cannot be split into 5 rooms"):
        split(Split([rectangle(0.0, 0.0, 5.0, 5.0)], []), 5, 2.4, np.random.default_rng(0))


@pytest.mark.parametrize("seed", range(5))
def test_doors_join_rooms_on_both_sides_of_a_wall(seed):
    rng = np.random.default_rng(seed)
    pen = Pen(rng, size_m=(20.0, 14.0), wall_m=(0.1, 0.1), door_m=(0.8, 1.2), glass=0.0)
    floor = Split([rectangle(0.0, 0.0, 20.0, 14.0)], [])
    split(floor, 6, 2.4, rng, oblique=0.5)
    draw_split(pen, floor, list("abcdef"), hub=2)
    rooms = {room.name: room.outline for room in pen.rooms}

    assert {name for door in pen.doors for name in door.joins} == set("abcdef")
    for door in pen.doors:
        along = (door.ends[1] - door.ends[0]) / door.width_m
        aside = np.array([-along[1], along[0]]) * 0.01
        sides = [{name for name in door.joins if covers(rooms[name], door.centre + k * aside)} for k in (-1, 1)]
        assert sorted(map(len, sides)) == [1, 1]
        assert sides[0] | sides[1] == set(door.joins)
