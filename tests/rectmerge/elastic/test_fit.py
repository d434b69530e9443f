import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rectmerge._kernels.banded import solve_banded
from rectmerge._kernels.spline_lattice import add_pulls, wall_pulls
from rectmerge.derived import derived_kept
from rectmerge.elastic.faces import Faces
from rectmerge.elastic.lattice import Lattice
from rectmerge.elastic.params import FaceParams, FitParams
from rectmerge.elastic.smoothness import smoothness
from rectmerge.errors import InputError
from tests.drawing import building
from tests.rectmerge.elastic.bent_maps import random_displacement


def dense(band):
    """The symmetric matrix of a lower band."""
    n, width = band.shape[0], band.shape[1] - 1
    matrix = np.zeros((n, n))
    for j in range(n):
        for d in range(min(width, n - 1 - j) + 1):
            matrix[j + d, j] = matrix[j, j + d] = band[j, d]
    return matrix


@given(st.integers(1, 30), st.integers(0, 8), st.integers(0, 10_000))
def test_the_banded_solution_is_the_dense_one(n, width, seed):
    rng = np.random.default_rng(seed)
    band = rng.normal(size=(n, width + 1))
    band[:, 0] = 2.0 + 2 * np.abs(band).sum(axis=1) + 2 * np.abs(band).sum()
    right = rng.normal(size=n)

    assert_allclose(solve_banded(band, right), np.linalg.solve(dense(band), right), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("shape", [(150, 240), (240, 150)])
def test_springs_of_a_known_displacement_give_it_back(shape):
    truth = random_displacement(0, shape, spacing=60, size=5)
    grid, rng = truth.lattice, np.random.default_rng(1)
    points = rng.uniform(0, 1, (4000, 2)) * (np.array(grid.counts) - 3) * 60 + grid.corner
    angles = rng.uniform(0, math.tau, 4000)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    band, right = np.zeros((2 * grid.node_count, grid.half_width + 1)), np.zeros(2 * grid.node_count)
    now = rng.normal(size=(grid.node_count, 2))
    offsets = truth.at(points) - type(truth)(grid, now).at(points)
    stiffness, force = wall_pulls(offsets, directions, np.ones(4000, bool), 1e9, 1.0, 0.0)

    add_pulls(band, right, now, grid.corner, grid.spacing, grid.counts, grid.steps, points, stiffness, force)

    assert_allclose(solve_banded(band, right).reshape(-1, 2), truth.coefficients, atol=1e-6)


def test_faces_of_a_map_are_found_once_in_one_piece_of_work():
    grid, params = building(), FaceParams()
    with derived_kept():
        kept = Faces.from_grid(grid, params)

        assert Faces.from_grid(grid, params) is kept
        assert Faces.from_grid(grid, FaceParams(directions=4)) is not kept
    assert Faces.from_grid(grid, params) is not kept


def slow_pull(offset, direction, weight, reach):
    """Stiffness, (2, 2), and force, (2,), of one partner along one direction, by Tukey's weight."""
    distance = offset @ direction
    tukey = (1 - (distance / reach) ** 2) ** 2 if abs(distance) < reach else 0.0
    return weight * tukey * np.outer(direction, direction), weight * tukey * distance * direction


def test_pulls_on_walls_are_those_across_and_along_each_wall():
    rng = np.random.default_rng(2)
    offsets, angles, is_pulled = rng.normal(size=(300, 2)), rng.uniform(0, math.tau, 300), rng.random(300) < 0.7
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    stiffness, force = wall_pulls(offsets, normals, is_pulled, 1.2, 3.0, 0.5)

    for k, offset in enumerate(offsets):
        across = slow_pull(offset, normals[k], 3.0 * is_pulled[k], 1.2)
        along = slow_pull(offset, np.array([-normals[k, 1], normals[k, 0]]), 0.5 * is_pulled[k], 1.2)
        xx, xy, yy = stiffness[k]
        assert_allclose([[xx, xy], [xy, yy]], across[0] + along[0], atol=1e-12)
        assert_allclose(force[k], across[1] + along[1], atol=1e-12)


@pytest.mark.parametrize(
    ("linear", "cost"),
    [
        ([[0, 0], [0, 0]], 0.0),
        ([[0, -0.1], [0.1, 0]], 0.0),  # a turn is free
        ([[0.01, 0], [0, 0]], 0.01**2),
        ([[0.01, 0], [0, 0.02]], 0.01**2 + 0.02**2),
        ([[0, 0.01], [0.01, 0]], 2 * 0.01**2),  # a shear, in both off-diagonals of the strain
    ],
)
def test_the_prior_charges_stretch_and_not_turn(linear, cost):
    lattice, patch, params = Lattice.over(np.zeros(2), np.array([300.0, 200.0]), 50.0), 80.0, FitParams()
    nx, ny = lattice.counts
    at = np.empty((lattice.node_count, 2))
    for ix in range(nx):
        for iy in range(ny):
            at[ix * lattice.steps[0] + iy * lattice.steps[1]] = 50.0 * (ix - 1), 50.0 * (iy - 1)
    c = (at @ np.array(linear, float).T + [4.0, 7.0]).ravel()

    energy = c @ dense(smoothness(lattice, patch, params)) @ c

    assert energy == pytest.approx(cost / params.strain_std**2 * 300 * 200 / patch**2, abs=1e-6)


def test_the_nearest_face_looks_the_same_way():
    faces = Faces.from_grid(building(), FaceParams())
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(faces.points), 300)
    normals = faces.normals[chosen]

    found = faces.nearest(faces.points[chosen] + rng.normal(0, 1, (300, 2)), normals)

    assert (found >= 0).all()
    assert np.median(np.linalg.norm(faces.points[found] - faces.points[chosen], axis=1)) < 2.5
    assert np.einsum("nk,nk->n", faces.normals[found], normals).min() > 0
    assert_allclose(np.linalg.norm(faces.normals, axis=1), 1)


def test_parameters_outside_their_range_are_refused():
    with pytest.raises(InputError, match="strain_std must be finite and > 0, got 0"):
        FitParams(strain_std=0.0)
    with pytest.raises(InputError, match="one stiffness for each reach, got 2 and 3"):
        FitParams(reaches=(0.1, 0.05), stiffness=(1.0, 1.0, 1.0))
