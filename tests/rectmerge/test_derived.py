import numpy as np
import pytest

from rectmerge import derived
from rectmerge.derived import derive, derived_kept
from rectmerge.grid import OccupancyGrid


def grid(side=4):
    return OccupancyGrid(np.zeros((side, side), np.int8))


class Maker:
    def __init__(self):
        self.count = 0

    def __call__(self):
        self.count += 1
        return self.count


def test_a_value_is_made_once_within_the_block_and_anew_outside():
    one, make = grid(), Maker()

    derive(one, "what", make)
    with derived_kept():
        kept = [derive(one, "what", make) for _ in range(3)]
        with derived_kept():
            within = derive(one, "what", make)
        after = derive(one, "what", make)
    outside = derive(one, "what", make)

    assert kept == [2, 2, 2]
    assert within == after == 2
    assert outside == 3


def test_an_equal_map_and_another_purpose_have_their_own():
    one, other, make = grid(), grid(), Maker()

    with derived_kept():
        values = [derive(one, "a", make), derive(other, "a", make), derive(one, "b", make), derive(one, "a", make)]

    assert values == [1, 2, 3, 1]


def test_what_was_not_asked_for_longest_goes_first_where_maps_are_large(monkeypatch):
    monkeypatch.setattr(derived, "MOST_CELLS_KEPT", 40)
    maps, make = [grid() for _ in range(3)], Maker()

    with derived_kept():
        derive(maps[0], "", make)
        derive(maps[1], "", make)
        derive(maps[0], "", make)
        derive(maps[2], "", make)
        again = [derive(each, "", make) for each in (maps[0], maps[1])]

    assert again == [1, 4]


def test_an_error_ends_the_block():
    one, make = grid(), Maker()

    def stop():
        raise ValueError("stop")

    with pytest.raises(ValueError, match="stop"), derived_kept():
        derive(one, "", stop)

    assert [derive(one, "", make) for _ in range(2)] == [1, 2]
