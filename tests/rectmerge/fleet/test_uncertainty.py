import numpy as np
import pytest

from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.uncertainty import Measurement, covariances

POSES = {
    "a": ComplexSimilarity(),
    "b": ComplexSimilarity(1.2 * np.exp(0.7j), 5 + 2j),
    "c": ComplexSimilarity(0.8 * np.exp(-2j), -3 + 9j),
}
CENTRES = {"a": 1 + 1j, "b": 4 - 2j, "c": 2 + 3j}
SPREAD = np.diag([0.01, 0.02, 0.05, 0.03]) ** 2


def sampled(rng, at, covariance):
    """Draw a placement error of a measurement: a similarity of A's frame about the point `at`."""
    angle, log_scale, tx, ty = rng.multivariate_normal(np.zeros(4), covariance)
    turn = np.exp(log_scale + 1j * angle)
    return ComplexSimilarity(turn, at - turn * at + tx + 1j * ty)


def deviation(true, found, centre):
    """Return (angle, ln scale, tx, ty) of a placement's error at a map's centre."""
    turn = np.log(found.turn / true.turn)
    moved = found.apply(centre) - true.apply(centre)
    return [turn.imag, turn.real, moved.real, moved.imag]


def test_the_covariance_of_a_chain_is_that_of_sampled_chains():
    pairs = [("a", "b", 2 + 1j), ("b", "c", 6 - 1j)]
    measurements = [Measurement(a, b, at, SPREAD) for a, b, at in pairs]

    found = covariances(POSES, CENTRES, measurements, "a")

    rng = np.random.default_rng(0)
    samples = {"b": [], "c": []}
    for _ in range(4000):
        pose = POSES["a"]
        for a, b, at in pairs:
            true = POSES[a].inverse() @ POSES[b]
            pose = pose @ sampled(rng, at, SPREAD) @ true
            samples[b].append(deviation(POSES[b], pose, CENTRES[b]))
    for name in "bc":
        deviations = np.sqrt(np.diag(found[name]))
        expected = np.cov(np.array(samples[name]).T)
        assert np.sqrt(np.diag(expected)) == pytest.approx(deviations, rel=0.06)
        assert expected / np.outer(deviations, deviations) == pytest.approx(
            found[name] / np.outer(deviations, deviations), abs=0.06
        )


def test_a_second_pair_makes_a_placement_surer():
    poses = {name: POSES[name] for name in "ab"}
    once = covariances(poses, CENTRES, [Measurement("a", "b", 2 + 1j, SPREAD)], "a")
    twice = covariances(poses, CENTRES, [Measurement("a", "b", 2 + 1j, SPREAD)] * 2, "a")

    assert twice["b"] == pytest.approx(once["b"] / 2)
    assert set(once) == {"b"}


def test_a_map_that_no_measurement_holds_has_no_covariance():
    assert covariances(POSES, CENTRES, [Measurement("a", "b", 2 + 1j, SPREAD)], "a") == {}
