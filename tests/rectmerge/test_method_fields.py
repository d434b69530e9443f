from dataclasses import dataclass, field

import pytest

from rectmerge.errors import InputError, MethodError
from rectmerge.method_fields import default_fields, field_values, flat_fields, to_text, with_fields


@dataclass(frozen=True, kw_only=True)
class Walls:
    reach_cells: float = 2.0
    steps: tuple[int, ...] = (3, 2, 1)

    def __post_init__(self):
        if self.reach_cells <= 0:
            raise InputError(f"reach_cells must be > 0, got {self.reach_cells}")


@dataclass(frozen=True, kw_only=True)
class Plain:
    walls: Walls = field(default_factory=Walls)
    count: int = 5
    is_quick: bool = False


@pytest.mark.parametrize(
    "fields", [{"walls.reach_cells": "4"}, {"walls.reach_cells": 4}, {"walls": {"reach_cells": 4.0}}]
)
def test_a_field_of_a_group_is_set_by_its_dotted_name_or_by_a_mapping(fields):
    assert with_fields(Plain, "plain", fields) == Plain(walls=Walls(reach_cells=4.0))


def test_several_fields_of_a_group_are_set_together_and_the_last_value_holds():
    made = with_fields(Plain, "plain", {"walls": {"reach_cells": 9}, "walls.steps": "5,4", "walls.reach_cells": 3})

    assert made == Plain(walls=Walls(reach_cells=3.0, steps=(5, 4)))


def test_a_group_may_be_given_whole():
    assert with_fields(Plain, "plain", {"walls": Walls(reach_cells=7.0)}).walls.reach_cells == 7.0


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"wals.reach_cells": 1}, "method 'plain' has no field 'wals'; it has: walls, count, is_quick"),
        ({"walls.reach": 1}, "group 'plain.walls' has no field 'reach'; it has: reach_cells, steps"),
        ({"walls": 3}, "plain.walls is a group of fields; it has: reach_cells, steps"),
        ({"count.more": 3}, "plain.count"),
        ({"walls.reach_cells": "far"}, "plain.walls.reach_cells=far: "),
        ({"walls.steps": "1,x"}, "plain.walls.steps=1,x: "),
        ({"walls.reach_cells": -1}, "plain.walls: reach_cells must be > 0, got -1"),
        ({"is_quick": "maybe"}, "plain.is_quick=maybe: must be true or false"),
    ],
)
def test_what_cannot_be_set_is_refused_in_one_line_that_names_it(fields, words):
    with pytest.raises(MethodError) as refused:
        with_fields(Plain, "plain", fields)

    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_defaults_are_listed_by_their_dotted_names_as_they_are_typed():
    flat = flat_fields(default_fields(Plain))

    assert {name: to_text(value) for name, value in flat.items()} == {
        "walls.reach_cells": "2.0",
        "walls.steps": "3,2,1",
        "count": "5",
        "is_quick": "False",
    }
    assert with_fields(Plain, "plain", {name: to_text(value) for name, value in flat.items()}) == Plain()


def test_the_values_of_a_method_are_plain_data():
    made = with_fields(Plain, "plain", {"walls.steps": "5,4"})

    assert field_values(made) == {"walls": {"reach_cells": 2.0, "steps": (5, 4)}, "count": 5, "is_quick": False}
