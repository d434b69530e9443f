"""The same maps given otherwise: swapped, turned, mirrored, padded, cropped. The verdict and the placement stay."""

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.analysis.displacement import displacement_cells
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import plans

MAX_MOVE_CELLS = 1.0
MAX_CONFIDENCE_CHANGE = 0.05


def turned(grid):
    cells = grid.occupancy
    return OccupancyGrid(np.ascontiguousarray(np.rot90(cells))), [[0, 1, 0], [-1, 0, cells.shape[1] - 1]]


def padded(grid):
    cells = np.pad(grid.occupancy, ((37, 11), (22, 45)), constant_values=-1)
    return OccupancyGrid(cells), [[1, 0, 22], [0, 1, 37]]


def cropped(grid):
    rows, cols = (np.flatnonzero((grid.occupancy >= 0).any(axis=axis)) for axis in (1, 0))
    cells = np.ascontiguousarray(grid.occupancy[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1])
    return OccupancyGrid(cells), [[1, 0, -cols[0]], [0, 1, -rows[0]]]


def mirrored(grid):
    cells = grid.occupancy
    return OccupancyGrid(np.ascontiguousarray(cells[:, ::-1])), [[-1, 0, cells.shape[1] - 1], [0, 1, 0]]


def same(grid):
    return grid, [[1, 0, 0], [0, 1, 0]]


WAYS = {
    "A turned": (turned, same),
    "B turned": (same, turned),
    "padded": (padded, padded),
    "cropped": (cropped, cropped),
    "mirrored": (mirrored, mirrored),
}


def square(matrix):
    return np.vstack([np.asarray(matrix, float), [0.0, 0.0, 1.0]])


def given_otherwise(a, b, change_a, change_b):
    """Align changed maps; return the answer, and its placement between the maps as they were."""
    (other_a, to_a), (other_b, to_b) = change_a(a), change_b(b)
    answer = align(other_a, other_b)
    matrix = np.linalg.inv(square(to_a)) @ square(answer.candidates[0].pixels.matrix) @ square(to_b)
    return answer, Similarity.from_matrix(matrix[:2])


def assert_same(b, answer, other, placement):
    assert other.verdict == answer.verdict
    if answer:
        assert other.confidence == pytest.approx(answer.confidence, abs=MAX_CONFIDENCE_CHANGE)
        assert displacement_cells(b, answer.candidates[0].pixels, placement) < MAX_MOVE_CELLS


@pytest.fixture(scope="module")
def pairs():
    """One pair that is accepted, and one of two places."""
    rooms = plans.office(1), plans.office(9)
    a = plans.see(rooms[0], degrees=33, scale=1.7, window=(-8, -8, 220, 236), noise=1, seed=1).grid
    b = plans.see(rooms[0], degrees=190, scale=1.4, window=(90, -8, 316, 236), noise=1, seed=2).grid
    other = plans.see(rooms[1], degrees=75, scale=1.4, noise=1, seed=3).grid
    return {"one place": (a, b, align(a, b)), "two places": (a, other, align(a, other))}


def test_the_pairs_are_an_accepted_and_a_refused_one(pairs):
    assert pairs["one place"][2]
    assert not pairs["two places"][2]


@pytest.mark.parametrize("name", ["one place", "two places"])
@pytest.mark.parametrize("way", WAYS)
def test_the_answer_stays_however_the_maps_are_given(pairs, name, way):
    a, b, answer = pairs[name]

    other, placement = given_otherwise(a, b, *WAYS[way])

    assert_same(b, answer, other, placement)


@pytest.mark.parametrize("name", ["one place", "two places"])
def test_the_answer_to_swapped_maps_is_the_inverse(pairs, name):
    a, b, answer = pairs[name]

    other = align(b, a)

    assert_same(b, answer, other, other.candidates[0].pixels.inverse())


@pytest.mark.parametrize("side", [806, 807, 808, 809])
@pytest.mark.parametrize("change", [turned, mirrored])
def test_a_large_map_given_otherwise_has_the_same_working_grid(change, side):
    rooms = plans.see(plans.office(2), degrees=20, scale=3.4, noise=1, seed=4).grid.occupancy
    cells = np.full((756, side), -1, np.int8)
    part = rooms[:756, :side]
    cells[: part.shape[0], : part.shape[1]] = part
    cells[0, 0] = cells[-1, -1] = 0
    grid = OccupancyGrid(cells)

    one, other = plans.prepared(grid).walled, plans.prepared(change(grid)[0]).walled

    assert one.factor > 1.0
    assert np.count_nonzero(one.free) == np.count_nonzero(other.free)
    assert len(one.walls) == len(other.walls)
    np.testing.assert_allclose(radii(one.walls), radii(other.walls), atol=1e-6)


def radii(points):
    """Distances of points from their middle, which no turn or mirror changes, sorted."""
    return np.sort(np.hypot(*(points - points.mean(axis=0)).T))
