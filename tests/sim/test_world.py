import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim.floorplans import Office, make_world
from sim.world import Prism, World, bar
from tests.sim.small_worlds import box_world

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@pytest.mark.parametrize(
    ("outline", "complaint"),
    [
        (SQUARE[::-1], "counter-clockwise"),
        (np.array([[0, 0], [2, 0], [2, 2], [1.9, 0.2]]), "convex"),
        (SQUARE[:2], "shape"),
    ],
)
def test_a_prism_refuses_what_is_no_convex_outline(outline, complaint):
    with pytest.raises(InputError, match=complaint):
        Prism(outline, 1.0)


def test_a_prism_refuses_heights_out_of_order():
    with pytest.raises(InputError, match="heights"):
        Prism(SQUARE, 1.0, 1.5)


@settings(deadline=None)
@given(st.floats(0.07, 0.5), st.floats(0.0, 3.1))
def test_the_raster_is_occupied_exactly_where_a_cell_centre_lies_in_an_obstacle(resolution, turn):
    along = np.array([np.cos(turn), np.sin(turn)])
    start, end = np.array([2.0, 2.0]) - along, np.array([2.0, 2.0]) + along
    grid = World(size=(4.0, 4.0), walls=(Prism(bar(start, end, 0.4), 2.0),)).raster(resolution)

    v, u = np.indices(grid.shape)
    offset = grid.pixel_to_map(np.stack([u, v], axis=-1)) - [2.0, 2.0]
    inside = (np.abs(offset @ along) < 1.0) & (np.abs(offset @ [-along[1], along[0]]) < 0.2)
    rim = np.minimum(np.abs(np.abs(offset @ along) - 1.0), np.abs(np.abs(offset @ [-along[1], along[0]]) - 0.2)) < 1e-6
    assert np.array_equal(grid.occupied[~rim], inside[~rim])


def test_the_raster_leaves_out_what_the_lasers_do_not_meet():
    shelf = Prism(SQUARE + 1.0, 2.0, bottom=1.5)

    assert not World(size=(3.0, 3.0), walls=(), furniture=(shelf,)).raster(0.1).occupied.any()


def test_the_raster_shows_rooms_free_and_the_outside_unknown():
    world = box_world()
    grid = World(size=(8.0, 4.0), walls=world.walls, rooms=world.rooms).raster(0.1)

    assert grid.free[20, 20]
    assert grid.unknown[:, 61:].all()


@pytest.mark.parametrize("resolution", [0.0, -0.1, float("nan")])
def test_the_raster_refuses_absurd_resolutions(resolution):
    with pytest.raises(InputError, match="resolution"):
        box_world().raster(resolution)


def test_a_world_survives_json_to_the_bit():
    world = make_world(Office(oblique=1.0), 3)
    again = World.from_json_dict(json.loads(json.dumps(world.to_json_dict())))

    assert again.to_json_dict() == world.to_json_dict()
    assert np.array_equal(again.raster(0.05).occupancy, world.raster(0.05).occupancy)


def test_turning_a_world_turns_its_raster_and_turning_it_back_restores_it():
    world = make_world(Office(size_m=(14.0, 10.0), rooms=6, yaw_deg=0.0), 3)
    quarter, back = world.turned(np.pi / 2), world.turned(0.7).turned(-0.7)

    assert quarter.size == pytest.approx((world.size[1], world.size[0]))
    assert np.array_equal(quarter.raster(0.05).occupancy, np.rot90(world.raster(0.05).occupancy))
    assert back.size == pytest.approx(world.size)
    for one, other in zip(world.obstacles, back.obstacles, strict=True):
        assert np.allclose(one.outline, other.outline)


def test_each_visit_finds_its_own_things():
    here = Prism(np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]), 1.0)
    world = replace(box_world(), visits=((), (here,)))

    assert not world.at_visit(0).visits[1]
    assert here in world.at_visit(1).furniture
    assert here not in world.at_visit(0).furniture + world.furniture
    assert World.from_json_dict(world.to_json_dict()).to_json_dict() == world.to_json_dict()
