"""The covariance of a fit: against draws, and against the errors of noisy pairs."""

import math

import numpy as np
import pytest

from rectmerge._kernels.placements import invert
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.robust.refinement import (
    Fit,
)
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import plans
from tests.rectmerge.robust.fits import fitted, nudged, views
from tests.rectmerge.robust.plans import as_placement, as_similarity


def test_the_inverse_of_a_fit_is_the_fit_the_other_way_round_and_twice_is_itself():
    a, b = views(1)
    fit = fitted(as_placement(plans.truth(a, b)), a, b)

    back, again = fit.inverse(), fit.inverse().inverse()

    np.testing.assert_allclose(back.placement, invert(fit.placement[None])[0])
    np.testing.assert_allclose(again.placement, fit.placement, rtol=1e-9)
    np.testing.assert_allclose(again.covariance, fit.covariance, rtol=1e-9, atol=1e-15)
    assert (again.residual_cells, again.surface_matched) == pytest.approx((fit.residual_cells, fit.surface_matched))


def made_fit() -> tuple[Fit, np.ndarray, np.ndarray]:
    """Make a fit with a drawn covariance about a pivot of B, and 2000 placements drawn from it."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 4)) * [[1e-3], [2e-3], [0.1], [0.05]]
    covariance = root @ root.T
    true, pivot = Similarity(1.3, 0.7, 12.0, -5.0), np.array([80.0, 35.0])
    steps = rng.multivariate_normal(np.zeros(4), covariance, 2000)
    drawn = [as_placement(nudged(true, turn, grow, (x, y), pivot)) for turn, grow, x, y in steps]
    return Fit(as_placement(true), covariance, 1.0, 0.3), np.array(drawn), pivot


def spread_about(pivots: np.ndarray, similarities: list[Similarity], mean: Similarity) -> np.ndarray:
    """Covariance of (angle, ln scale, x, y) of drawn similarities, x and y being where they put a point."""
    rows = [
        [math.remainder(s.angle - mean.angle, math.tau), math.log(s.scale / mean.scale), *(s.apply(pivots))]
        for s in similarities
    ]
    return np.cov(np.array(rows).T)


def assert_alike(covariance: np.ndarray, sampled: np.ndarray) -> None:
    """Compare covariances in units of their own standard deviations; 2000 draws tell them to about 3 %."""
    unit = np.sqrt(np.diag(sampled))
    np.testing.assert_allclose(covariance / np.outer(unit, unit), sampled / np.outer(unit, unit), atol=0.1)


def test_the_covariance_of_the_inverse_is_that_of_inverted_draws():
    fit, drawn, pivot = made_fit()
    at_a = as_similarity(fit.placement).apply(pivot)

    back = fit.inverse()

    draws = [as_similarity(p) for p in invert(drawn)]
    assert_alike(back.covariance, spread_about(at_a, draws, as_similarity(back.placement)))


@pytest.mark.parametrize(
    ("resolution", "origin"), [(None, (0.0, 0.0, 0.0)), (0.05, (3.0, -2.0, 0.6)), (0.2, (1.0, 1.0, -2.5))]
)
def test_the_covariance_in_the_map_frame_is_that_of_draws_taken_there(origin, resolution):
    fit, drawn, pivot = made_fit()
    a = OccupancyGrid(np.zeros((70, 90), np.int8), resolution, origin)
    b = OccupancyGrid(np.zeros((60, 50), np.int8), 0.07, (0.3, 0.2, 1.0))

    covariance = fit.covariance_in_map_frame(a)

    mean = pixels_to_map_frame(as_similarity(fit.placement), a, b)
    draws = [pixels_to_map_frame(as_similarity(p), a, b) for p in drawn]
    assert_alike(covariance, spread_about(b.pixel_to_map(pivot), draws, mean))


@pytest.mark.slow
def test_the_covariance_of_noisy_pairs_is_of_the_size_of_their_errors():
    squares = []
    for seed in range(30):
        rooms = plans.office(seed)
        a = plans.see(rooms, degrees=11 * seed, noise=1, seed=seed)
        b = plans.see(rooms, degrees=37 * seed, scale=1.1, noise=1, seed=seed + 100)
        fit = fitted(as_placement(plans.truth(a, b)), a, b)
        off = plans.truth(a, b).inverse() @ as_similarity(fit.placement)
        squares.append([off.angle**2 / fit.covariance[0, 0], math.log(off.scale) ** 2 / fit.covariance[1, 1]])

    angle, scale = np.median(squares, axis=0) / 0.45  # the median of a chi-square variable of one degree
    assert 1 / 4 < math.sqrt(angle * scale) < 4
    assert 1 / 16 < angle < 16
    assert 1 / 16 < scale < 16
