import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rectmerge.elastic.lattice import Displacement, Lattice
from rectmerge.elastic.params import AcceptanceParams
from tests.rectmerge.elastic.bent_maps import random_displacement

ACCEPT = AcceptanceParams()
SHAPE = (300, 420)


def points_around(seed):
    """Points on the map of SHAPE and around it."""
    return np.random.default_rng(seed).uniform(-80, 480, (200, 2))


@given(st.integers(0, 10_000), st.floats(20, 150), st.floats(0, 0.3))
def test_the_inverse_undoes_every_displacement_that_does_not_fold(seed, spacing, slope):
    bend = random_displacement(seed, SHAPE, spacing=spacing, size=slope * spacing)
    determinant, least, greatest = bend.extremes()
    if determinant < ACCEPT.min_determinant or least < ACCEPT.min_stretch or greatest > ACCEPT.max_stretch:
        return  # refused before anybody asks for its inverse
    points = points_around(seed)

    assert np.abs(bend.undo(bend.apply(points)) - points).max() < 0.05
    assert np.abs(bend.apply(bend.undo(points)) - points).max() < 0.05


@given(st.integers(0, 10_000))
def test_the_jacobian_is_the_difference_quotient(seed):
    bend = random_displacement(seed, SHAPE, spacing=60, size=10)
    points, step = points_around(seed), 1e-4
    away = np.abs(bend.at(points + 2 * step) - bend.at(points - 2 * step)).max(axis=1) < 1  # all of them
    sides = [(bend.apply(points + e) - bend.apply(points - e)) / (2 * step) for e in step * np.eye(2)]

    inside = bend.lattice.contains(points + 2 * step) & bend.lattice.contains(points - 2 * step)
    assert away.all()
    assert_allclose(bend.jacobian(points)[inside], np.stack(sides, axis=-1)[inside], atol=1e-6)


@pytest.mark.parametrize("shape", [(300, 420), (420, 300)])
def test_splines_reproduce_an_affine_displacement(shape):
    lattice = Lattice.over(np.zeros(2), np.array(shape[::-1], float), 50.0)
    nx, ny = lattice.counts
    nodes = np.empty((nx * ny, 2))
    for ix in range(nx):
        for iy in range(ny):
            nodes[ix * lattice.steps[0] + iy * lattice.steps[1]] = 50.0 * (ix - 1), 50.0 * (iy - 1)
    linear = np.array([[0.02, -0.05], [0.04, 0.01]])
    bend = Displacement(lattice, nodes @ linear.T + [3.0, -2.0])
    points = np.random.default_rng(0).uniform(0, 300, (50, 2))

    assert_allclose(bend.at(points), points @ linear.T + [3.0, -2.0], atol=1e-9)
    assert_allclose(bend.jacobian(points), np.broadcast_to(np.eye(2) + linear, (50, 2, 2)), atol=1e-12)


def test_a_fold_shows_in_the_determinant():
    bend = random_displacement(1, SHAPE, spacing=40, size=40)

    assert bend.extremes()[0] < 0


def test_beyond_its_lattice_a_displacement_stays_as_on_the_edge():
    bend = random_displacement(2, SHAPE, spacing=60, size=10)
    x, y = bend.lattice.corner

    assert_allclose(bend.at([x - 500.0, y + 70.0]), bend.at([x, y + 70.0]))
    assert bend.lattice.contains([[x + 1, y + 1], [x - 1, y + 1]]).tolist() == [True, False]


def test_points_may_have_any_shape():
    bend = random_displacement(3, SHAPE, spacing=60, size=10)

    assert bend.apply(np.zeros((3, 4, 2))).shape == (3, 4, 2)
    assert bend.jacobian([1.0, 2.0]).shape == (2, 2)
    assert bend.undo(np.zeros((0, 2))).shape == (0, 2)
