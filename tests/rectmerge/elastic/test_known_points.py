import numpy as np
from numpy.testing import assert_allclose

from rectmerge.elastic.known_points import fit_to_points
from tests.rectmerge.elastic.bent_maps import random_displacement


def test_a_smooth_displacement_is_found_from_its_points():
    truth = random_displacement(0, (400, 500), spacing=150, size=6)
    points = np.random.default_rng(1).uniform([0, 0], [500, 400], (600, 2))

    found = fit_to_points(points[:300], truth.apply(points[:300]), std_cells=0.1)

    off = found.at(points[300:]) - truth.at(points[300:])
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.1 * np.sqrt((truth.at(points) ** 2).sum(axis=1).mean())


def test_a_shift_is_found_from_two_points():
    points = np.array([[0.0, 0.0], [100.0, 50.0]])

    assert_allclose(fit_to_points(points, points + np.array([3.0, -2.0])).at([[40.0, 30.0]]), [[3.0, -2.0]], atol=1e-6)
