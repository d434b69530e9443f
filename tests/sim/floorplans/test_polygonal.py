import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.floorplans import Polygonal, make_world

PLAIN = {"yaw_deg": 0.0, "furniture": 0.0, "glass": 0.0, "shut": 0.0, "changed": 0.0, "oblique": 0.0}
PARALLEL_WITHIN_DEG = 1.0


def parallel_pairs(outline):
    """Return the number of pairs of parallel sides of an outline (N, 2), and whether the longest side is in one."""
    edges = np.roll(outline, -1, axis=0) - outline
    angles = np.degrees(np.arctan2(edges[:, 1], edges[:, 0]))
    off = np.abs((angles[:, None] - angles + 90.0) % 180.0 - 90.0)
    pairs = np.argwhere(np.triu(off < PARALLEL_WITHIN_DEG, k=1))
    return len(pairs), int(np.argmax(np.hypot(*edges.T))) in pairs


@pytest.mark.parametrize(("outline", "count"), [("irregular", 0), ("trapezoid", 1), ("rectangle", 2)])
@pytest.mark.parametrize("seed", range(6))
def test_an_outline_has_the_pairs_of_parallel_sides_that_its_name_says(outline, count, seed):
    (room,) = make_world(Polygonal(outline=outline, rooms=1, **PLAIN), seed).rooms

    assert parallel_pairs(room.outline) == (count, count > 0)


@pytest.mark.parametrize("rooms", [1, 2, 3, 4])
def test_rooms_of_a_rectangle_are_rectangles_where_no_wall_is_oblique(rooms):
    world = make_world(Polygonal(outline="rectangle", rooms=rooms, **PLAIN), 1)

    assert len(world.rooms) == rooms
    for room in world.rooms:
        assert room.area_m2 == pytest.approx(np.prod(room.outline.max(axis=0) - room.outline.min(axis=0)))


@pytest.mark.parametrize("seed", range(6))
def test_a_u_is_one_space_of_three_unlike_rectangles(seed):
    world = make_world(Polygonal(outline="u", rooms=1, **PLAIN), seed)
    bar, *arms = (room.outline.max(axis=0) - room.outline.min(axis=0) for room in world.rooms)

    assert len(arms) == 2
    assert not world.doors
    assert sum(room.area_m2 for room in world.rooms) < 0.9 * world.size[0] * world.size[1]
    assert bar[0] > arms[0][0] + arms[1][0] + 3.0
    assert abs(arms[0] - arms[1]).min() > 0.3


@pytest.mark.parametrize(
    ("knobs", "complaint"),
    [
        ({"outline": "star"}, "outline must be one of cut, irregular, trapezoid, rectangle, u, got 'star'"),
        ({"rooms": 2}, "rooms must be 3 to 9, got 2"),
        ({"outline": "u", "rooms": 2}, "rooms must be 1 to 1, got 2"),
        ({"outline": "irregular", "rooms": 0}, "rooms must be 1 to 9, got 0"),
    ],
)
def test_knobs_that_exclude_each_other_are_refused(knobs, complaint):
    with pytest.raises(InputError, match=complaint):
        Polygonal(**knobs)
