import itertools

import numpy as np
import pytest

from sim.floorplans.drafting import Pen
from sim.floorplans.pieces import Piece, block
from sim.floorplans.shapes import rectangle
from sim.floorplans.visits import Furniture, change_furniture, shut_doors
from sim.world import Door

MODEL = block(1.0, 1.0, 1.0)
PIECES = [Piece(f"room {k % 4}", MODEL, MODEL) for k in range(40)]


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_as_many_pieces_change_as_asked_for(share):
    moved = Piece("elsewhere", MODEL, MODEL)
    furniture = change_furniture(PIECES, share, lambda piece: moved, np.random.default_rng(0))
    once = [piece for visit in furniture.once for piece in visit]

    assert len(furniture.always) == 40 - round(40 * share)
    assert len([piece for piece in once if piece is not moved]) == round(40 * share)
    assert set(map(id, furniture.always)).isdisjoint(map(id, once))
    assert all(furniture.once) == (share > 0)


def test_a_piece_with_no_other_place_is_removed_or_added():
    furniture = change_furniture(PIECES, 1.0, lambda piece: None, np.random.default_rng(0))

    assert len(furniture.once[0]) + len(furniture.once[1]) == 40
    assert min(map(len, furniture.once)) > 10


def test_thinning_takes_from_the_rooms_named_and_ends_in_nothing():
    furniture = Furniture(tuple(PIECES), (tuple(PIECES[:2]), ()))
    thinner = furniture.thinned(["room 1"])

    assert [piece for piece in thinner.always if piece.room != "room 1"] == [p for p in PIECES if p.room != "room 1"]
    assert 0 < sum(piece.room == "room 1" for piece in thinner.always) < 10
    assert (len(thinner.once[0]), thinner.once[1]) == (1, ())
    while thinner.stands_in("room 1"):
        before, thinner = thinner, thinner.thinned(["room 1"])
        assert len(thinner.always) < len(before.always)


def rooms_joined_by(pairs):
    pen = Pen(np.random.default_rng(0), size_m=(9.0, 9.0), wall_m=(0.1, 0.1), door_m=(0.8, 0.8), glass=0.0)
    for name in sorted({name for pair in pairs for name in pair}):
        pen.room(name, rectangle(0.0, 0.0, 1.0, 1.0))
    pen.doors = [Door(np.array([[k, 0.0], [k + 0.8, 0.0]]), pair) for k, pair in enumerate(pairs)]
    return pen


def test_no_door_of_a_tree_can_be_shut():
    leaves = shut_doors(rooms_joined_by(["ab", "bc", "bd"]), 1.0, may_differ=True)

    assert all(door.is_open for door in leaves.doors)
    assert not leaves.always
    assert leaves.once == ((), ())


def test_shut_doors_leave_all_rooms_joined():
    pairs = [tuple(pair) for pair in itertools.combinations("abcde", 2)]
    leaves = shut_doors(rooms_joined_by(pairs), 1.0, may_differ=False)
    still_open = [set(door.joins) for door in leaves.doors if door.is_open]
    reached = {"a"}
    for _ in range(5):
        reached |= set().union(*(pair for pair in still_open if pair & reached))

    assert reached == set("abcde")
    assert len(still_open) == 4
    assert len(leaves.always) == 6


def test_a_share_of_the_doors_is_shut_some_during_one_visit_only():
    pairs = [tuple(pair) for pair in itertools.combinations("abcdefgh", 2)]
    leaves = shut_doors(rooms_joined_by(pairs), 0.5, may_differ=True)

    assert sum(not door.is_open for door in leaves.doors) == 14
    assert len(leaves.always) + len(leaves.once[0]) + len(leaves.once[1]) == 14
    assert leaves.always
    assert leaves.once[0]
    assert leaves.once[1]
