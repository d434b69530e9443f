import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

coordinates = st.floats(-1e3, 1e3)
similarities = st.builds(Similarity, st.floats(0.01, 100), st.floats(-math.pi, math.pi), coordinates, coordinates)
points = arrays(np.float64, st.tuples(st.integers(3, 12), st.just(2)), elements=st.floats(-100, 100, width=32))


def assert_same(similarity: Similarity, wanted: Similarity) -> None:
    np.testing.assert_allclose(similarity.matrix, wanted.matrix, rtol=1e-7, atol=1e-5)


@settings(max_examples=50)
@given(similarities, points)
def test_the_inverse_brings_every_point_back(similarity, at):
    np.testing.assert_allclose(similarity.inverse().apply(similarity.apply(at)), at, atol=1e-6)


@settings(max_examples=50)
@given(similarities, similarities, points)
def test_composition_applies_the_right_one_first(second, first, at):
    together = (second @ first).apply(at)

    np.testing.assert_allclose(together, second.apply(first.apply(at)), rtol=1e-9, atol=1e-6)


@settings(max_examples=50)
@given(similarities)
def test_a_matrix_says_the_same_as_its_similarity(similarity):
    assert_same(Similarity.from_matrix(similarity.matrix), similarity)


@settings(max_examples=50)
@given(similarities, points)
def test_fit_recovers_the_similarity_that_moved_the_points(similarity, at):
    assume(np.ptp(at, axis=0).max() > 1)

    assert_same(Similarity.fit(at, similarity.apply(at)), similarity)


@settings(max_examples=50)
@given(points, st.booleans())
def test_fit_never_mirrors_even_if_the_points_are(at, upside_down):
    assume(np.ptp(at, axis=0).min() > 1)
    mirrored = at * ([1, -1] if upside_down else [-1, 1])

    try:
        fitted = Similarity.fit(at, mirrored)
    except InputError:
        return  # a cloud as long as it is wide has no best rotation onto its mirror image

    assert np.linalg.det(fitted.matrix[:, :2]) == pytest.approx(fitted.scale**2)
    assert fitted.scale > 0


@settings(max_examples=50)
@given(similarities, points, st.integers(0, 2**32 - 1))
def test_fit_leaves_no_better_similarity_nearby(similarity, at, seed):
    assume(np.ptp(at, axis=0).max() > 1)
    rng = np.random.default_rng(seed)
    target = similarity.apply(at) + rng.normal(0, similarity.scale, at.shape)
    fitted = Similarity.fit(at, target)

    def cost(candidate: Similarity) -> float:
        return float(((candidate.apply(at) - target) ** 2).sum())

    nudged = Similarity(
        fitted.scale * rng.uniform(0.99, 1.01), fitted.angle + rng.normal(0, 0.01), fitted.tx, fitted.ty
    )
    assert cost(fitted) <= cost(nudged) * (1 + 1e-9)


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan, math.inf])
def test_a_scale_that_is_not_positive_and_finite_is_refused(scale):
    with pytest.raises(InputError):
        Similarity(scale)


@pytest.mark.parametrize(
    "matrix",
    [
        [[1, 0, 0], [0, -1, 0]],  # a reflection
        [[1, 0, 0], [0, 2, 0]],  # not uniform
        [[0, 0, 0], [0, 0, 0]],
        [[math.nan, 0, 0], [0, math.nan, 0]],
        np.eye(3),
    ],
)
def test_a_matrix_that_is_no_similarity_is_refused(matrix):
    with pytest.raises(InputError):
        Similarity.from_matrix(matrix)


@pytest.mark.parametrize(("source", "target"), [([[0, 0]], [[1, 1]]), ([[1, 1]] * 3, [[0, 0], [1, 0], [2, 0]])])
def test_points_that_determine_nothing_are_refused(source, target):
    with pytest.raises(InputError):
        Similarity.fit(source, target)
