from importlib.metadata import EntryPoint

import numpy as np
import pytest

from rectmerge import methods
from rectmerge.aligning import align
from rectmerge.errors import MethodError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import available, make_method
from rectmerge.similarity import Similarity
from tests import drawing
from tests.marking import some_slow

MADE = Similarity()  # a dataclass, but not a class


@pytest.mark.parametrize("value", ["fractions:Fraction", "tests.rectmerge.test_methods:MADE"])
def test_what_is_no_class_of_methods_is_refused(monkeypatch, value):
    point = EntryPoint(name="plain", value=value, group=methods.GROUP)
    monkeypatch.setattr(methods, "available", lambda: {"plain": point})

    with pytest.raises(MethodError, match=f"{value} is no dataclass"):
        make_method("plain")


def test_an_unknown_method_is_refused_and_the_known_ones_are_named():
    with pytest.raises(MethodError, match=methods.DEFAULT_METHOD):
        make_method("no-such-method")


@pytest.mark.parametrize("name", available())
def test_a_field_that_a_method_does_not_have_is_refused(name):
    with pytest.raises(MethodError, match="no_such_field"):
        make_method(name, no_such_field=1)


# What every registered method promises, on a building that it can solve.


def turned_views() -> tuple[OccupancyGrid, OccupancyGrid, Similarity]:
    """Draw the building at two angles about half a turn apart, as the paper's method needs them, and the truth."""
    (a, from_a), (b, from_b) = drawing.tilted(38), drawing.tilted(200)
    return a, b, from_a.inverse() @ from_b


COARSE = {"paper": 2.0}  # its scale is the quotient of two widths in whole cells: one cell of 50 is 2 %


def grids_apart(placement: Similarity, wanted: Similarity, grid: OccupancyGrid) -> float:
    """Return the largest distance in cells between where two placements put a grid's corners."""
    height, width = grid.shape
    corners = [[0, 0], [width, 0], [0, height], [width, height]]
    return float(np.abs(placement.apply(corners) - wanted.apply(corners)).max())


@pytest.mark.parametrize("name", some_slow(available(), "robust", "paper", "keypoints"))
def test_a_map_aligned_with_itself_gives_identity(name):
    a, _, _ = turned_views()

    alignment = align(a, a, method=name)

    assert alignment, alignment.reason
    assert grids_apart(alignment.candidates[0].pixels, Similarity(), a) < 2


@pytest.mark.parametrize("name", some_slow(available(), "robust", "paper", "keypoints"))
def test_swapped_inputs_give_the_inverse(name):
    a, b, _ = turned_views()

    there, back = align(a, b, method=name), align(b, a, method=name)

    assert there, there.reason
    assert back, back.reason
    assert grids_apart(back.candidates[0].pixels @ there.candidates[0].pixels, Similarity(), b) < 3 * COARSE.get(
        name, 1.0
    )


@pytest.mark.parametrize("name", some_slow(available(), "robust", "paper", "keypoints"))
def test_a_clean_turned_map_is_placed_within_two_cells_where_the_scale_is_exact(name):
    a, b, truth = turned_views()

    alignment = align(a, b, method=name)

    assert alignment, alignment.reason
    assert grids_apart(alignment.candidates[0].pixels, truth, b) < 2 * COARSE.get(name, 1.0)


@pytest.mark.parametrize("name", some_slow(available(), "robust", "paper", "keypoints"))
def test_the_same_seed_gives_the_same_answer(name):
    a, b, _ = turned_views()

    first, second = (align(a, b, method=name, seed=3).as_dict() | {"seconds": 0} for _ in range(2))

    assert first == second


@pytest.mark.parametrize("name", available())
def test_an_empty_map_gives_a_reason(name):
    empty = OccupancyGrid(np.full((40, 40), -1, np.int8))

    alignment = align(drawing.building(), empty, method=name)

    assert alignment.verdict == "rejected"
    assert alignment.reason


@pytest.mark.parametrize("name", available())
def test_a_map_with_hardly_anything_in_it_gives_an_answer_not_an_error(name):
    occupancy = np.full((40, 40), -1, np.int8)
    occupancy[20, 20:23] = 0

    alignment = align(OccupancyGrid(occupancy), drawing.building(), method=name)

    assert alignment.reason


@pytest.mark.parametrize(("text", "value"), [("true", True), ("1", True), ("no", False), ("0", False), (False, False)])
def test_a_switch_is_read_as_people_type_it(text, value):
    assert make_method("paper", inclusive_sides=text).inclusive_sides is value


@pytest.mark.parametrize(
    ("name", "field", "value"),
    [
        ("paper", "inclusive_sides", "maybe"),
        ("paper", "delta_cells", "wide"),
        ("paper-repaired", "orientation", "compass"),
        ("paper", "weights", "1,2"),
        ("paper", "min_area_cells", "-1"),
        ("robust", "max_candidates", "0"),
        ("robust", "propose.max_refined", "none"),
        ("robust", "confidence.rigid", "1,two"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_its_method_field_and_value(name, field, value):
    with pytest.raises(MethodError, match=rf"{name}.*{field}.*{value}"):
        make_method(name, **{field: value})
