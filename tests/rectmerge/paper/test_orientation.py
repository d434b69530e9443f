import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.paper.edges import EDGES, edge_lines, edge_points, edge_rectangles, largest_neighbours
from rectmerge.paper.orientation import orthogonal_orientation, smallest_turn
from rectmerge.paper.rmap import rmap
from tests.rectmerge.paper import naive, plans


def residual_deg(turn: float, degrees: float) -> float:
    """How far a turn leaves a map, turned by so many degrees, from the axes."""
    return abs(math.remainder(math.degrees(turn) + degrees, 90))


def turned_room(degrees: float) -> np.ndarray:
    grid = np.zeros((160, 220), np.uint8)
    corners = cv2.boxPoints(((110.0, 80.0), (120.0, 60.0), -degrees))
    cv2.fillPoly(grid, [np.rint(corners).astype(np.int32)], 1)
    return grid > 0


def test_fourteen_elements_make_ninety_one_lines():
    points = np.random.default_rng(0).random((14, 2))

    assert len(edge_lines(points).angles) == math.comb(14, 2) == 91


# no point lies at exactly such a distance from a line through points of a 12 x 12 grid, where rounding would decide
@given(st.integers(0, 2**32 - 1), st.integers(2, 8), st.integers(0, 3).map(lambda whole: whole + 1 / math.pi))
def test_inliers_agree_with_counting_line_by_line(seed, count, tolerance):
    points = np.unique(np.random.default_rng(seed).integers(0, 12, (count, 2)), axis=0).astype(float)

    assert edge_lines(points, tau_cells=tolerance).inliers.tolist() == naive.line_inliers(points, tolerance)


@pytest.mark.parametrize("degrees", [-40, -27, -12, 7, 18, 27, 33, 42])
def test_a_turned_room_is_laid_along_the_axes(degrees):
    orientation = orthogonal_orientation(rmap(turned_room(degrees)))

    assert orientation is not None
    assert residual_deg(orientation.turn, degrees) < 2


@pytest.mark.parametrize("degrees", [27, 117, 207, 297, 225])
def test_a_turned_plan_is_laid_along_the_axes_to_half_a_degree(degrees):
    grid, _ = plans.moved(plans.floor_plan(), degrees)
    orientation = orthogonal_orientation(rmap(grid.free))

    assert orientation is not None
    assert residual_deg(orientation.turn, degrees) < 0.5


def test_the_turn_by_45_degrees_is_negative_as_in_the_paper():
    grid, _ = plans.moved(plans.floor_plan(), 225)
    orientation = orthogonal_orientation(rmap(grid.free))

    assert orientation is not None
    assert math.degrees(orientation.turn) == pytest.approx(-45, abs=0.5)


@given(st.floats(-10, 10))
def test_the_smallest_turn_brings_an_angle_to_an_axis(angle):
    turn = smallest_turn(angle)

    assert math.radians(-45.5) <= turn <= math.radians(44.5)
    assert abs(math.remainder(angle - turn, math.pi / 2)) < 1e-9


def test_a_series_steps_to_the_largest_neighbour_and_visits_nothing_twice():
    rectangles = rmap(turned_room(27))

    for side, series in largest_neighbours(rectangles, 1).items():
        assert series
        assert len({1, *series}) == 1 + len(series)
        for here, there in zip([1, *series], series, strict=False):
            fresh = [
                n for n in rectangles.connections(here, side).tolist() if n not in {1, *series[: series.index(there)]}
            ]
            assert there == min(fresh)


def test_the_shortest_series_cuts_the_others_unless_a_depth_is_given():
    rectangles = rmap(turned_room(27))
    series = largest_neighbours(rectangles, 1)
    shortest = min(map(len, series.values()))

    assert edge_rectangles(rectangles, 1) == edge_rectangles(rectangles, 1, path_depth=shortest)
    assert len(edge_rectangles(rectangles, 1, path_depth=1)["NW"]) < len(edge_rectangles(rectangles, 1)["NW"])


def test_an_edge_holds_its_two_series_and_their_outward_neighbours():
    rectangles = rmap(turned_room(27))
    series = largest_neighbours(rectangles, 1)
    depth = min(map(len, series.values()))

    wanted = {1, *series["up"][:depth], *series["left"][:depth]}
    wanted |= {int(n) for member in series["up"][:depth] for n in rectangles.connections(member, "left")}
    wanted |= {int(n) for member in series["left"][:depth] for n in rectangles.connections(member, "up")}

    assert edge_rectangles(rectangles, 1)["NW"] == sorted(wanted)


def test_vertices_lie_on_the_side_their_edge_names():
    rectangles = rmap(np.ones((4, 6), bool))

    corners = {edge: edge_points(rectangles, [1], edge).tolist() for edge in EDGES}

    assert corners == {"NW": [[0, 0]], "NE": [[6, 0]], "SW": [[0, 4]], "SE": [[6, 4]]}


def test_an_orthogonal_room_is_left_as_it_is():
    orientation = orthogonal_orientation(rmap(np.pad(np.ones((20, 30), bool), 2)))

    assert orientation is not None
    assert orientation.turn == 0


def test_no_parallel_edges_give_no_orientation():
    assert orthogonal_orientation(rmap(plans.stairs())) is None


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_noise_makes_no_crash_and_no_other_answer_than_a_small_turn(seed):
    free = np.random.default_rng(seed).random((25, 25)) < 0.7
    orientation = orthogonal_orientation(rmap(free))

    assert orientation is None or abs(orientation.turn) <= math.radians(45.5)


@pytest.mark.parametrize("tolerance", [{"tau_cells": -1}, {"slope_tolerance_deg": -1}])
def test_a_negative_tolerance_is_refused(tolerance):
    with pytest.raises(InputError, match="tolerances"):
        orthogonal_orientation(rmap(np.ones((2, 2), bool)), **tolerance)


@pytest.mark.parametrize(("slope", "turned_deg", "upright_deg"), [((2, 1), 27, 0.4349), ((1, 1), 225, 180.0)])
def test_the_turns_that_the_paper_prints_are_those_of_its_slopes(slope, turned_deg, upright_deg):
    # a map turned counter-clockwise by 27 degrees has edges that rise by one cell in two: figure 5 prints -26.5651
    turn = math.degrees(smallest_turn(-math.atan2(slope[1], slope[0])))

    assert turn == pytest.approx({27: -26.5651, 225: -45.0}[turned_deg], abs=5e-5)
    assert turned_deg + turn == pytest.approx(upright_deg, abs=5e-5)
    assert turn + 90 == pytest.approx({27: 63.4349, 225: 45.0}[turned_deg], abs=5e-5)  # as section IV has it


def test_the_fourteen_rectangles_of_the_papers_edge_make_its_ninety_one_lines():
    upper_left, left_upper = {7, 23, 27, 36, 47, 82, 84, 86}, {8, 20, 44, 73, 76}  # eq. 5a and 5b
    north_west = {1} | upper_left | left_upper  # eq. 6a

    assert len(north_west) == 14
    assert len(edge_lines(np.random.default_rng(1).random((len(north_west), 2))).inliers) == 91
