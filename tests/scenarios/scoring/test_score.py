import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from scenarios.scoring.score import (
    Errors,
    grade,
    measure_errors,
    outcome_of,
    stratum_of,
)
from tests.scenarios.known_answers import TRUTH, pair

similarities = st.builds(
    Similarity,
    st.floats(0.5, 2.0),
    st.floats(-math.pi, math.pi),
    st.floats(-100, 100),
    st.floats(-100, 100),
)


def errors(e_over_l=0.0, rotation_deg=0.0, scale_pct=0.0, *, reflected=False):
    return Errors(
        e_px=100 * e_over_l,
        e_over_l=e_over_l,
        e_m=None,
        rotation_deg=rotation_deg,
        scale_pct=scale_pct,
        reflected=reflected,
    )


@given(similarities)
def test_the_truth_itself_has_no_error_and_is_fine(truth):
    measured = measure_errors(truth, pair(truth=truth))

    assert measured.e_px < 1e-9
    assert measured.rotation_deg < 1e-9
    assert measured.scale_pct < 1e-9
    assert grade(measured, 0.0) == "fine"


@given(similarities, st.floats(0, math.pi))
def test_a_mirrored_answer_is_never_right(truth, axis):
    mirror = np.array([[math.cos(axis), math.sin(axis)], [math.sin(axis), -math.cos(axis)]])
    matrix = truth.matrix.copy()
    matrix[:, :2] = matrix[:, :2] @ mirror

    measured = measure_errors(matrix, pair(truth=truth))

    assert measured.reflected
    assert grade(measured, residual_over_l=1.0) == "off"


@given(similarities, st.floats(-30, 30), st.floats(-30, 30))
def test_a_shift_is_measured_as_its_length(truth, dx, dy):
    shifted = replace(truth, tx=truth.tx + dx, ty=truth.ty + dy)

    measured = measure_errors(shifted, pair(truth=truth))

    assert measured.e_px == pytest.approx(math.hypot(dx, dy), abs=1e-9)


@given(similarities, st.floats(-179, 179), st.floats(0.5, 2.0))
def test_turn_and_scale_are_measured_as_they_were_made(truth, degrees, factor):
    off = Similarity(factor, math.radians(degrees)) @ truth

    measured = measure_errors(off, pair(truth=truth))

    assert measured.rotation_deg == pytest.approx(abs(degrees), abs=1e-6)
    assert measured.scale_pct == pytest.approx(100 * abs(factor - 1), abs=1e-6)


def test_metres_are_told_where_the_row_knows_the_hidden_resolution():
    shifted = replace(TRUTH, tx=TRUTH.tx + 2)

    assert measure_errors(shifted, pair()).e_m is None
    assert measure_errors(shifted, pair(info={"resolution_a": 0.05})).e_m == pytest.approx(0.1)


@pytest.mark.parametrize("bad", [np.eye(3), [[1, 0, math.nan], [0, 1, 0]], [1, 2, 3]])
def test_an_answer_that_is_no_finite_matrix_is_refused(bad):
    with pytest.raises(InputError, match="finite 2x3"):
        measure_errors(bad, pair())


def test_an_unrelated_pair_cannot_be_measured():
    with pytest.raises(InputError, match="no truth"):
        measure_errors(TRUTH, pair(related=False))


@pytest.mark.parametrize(
    ("measured", "residual", "expected"),
    [
        (errors(0.0024), 0.0, "fine"),
        (errors(0.0025), 0.0, "right"),
        (errors(0.0099), 0.0, "right"),
        (errors(0.01), 0.0, "coarse"),
        (errors(0.0499), 0.0, "coarse"),
        (errors(0.05), 0.0, "off"),
        (errors(0.0, 4.99), 0.0, "fine"),
        (errors(0.0, 5.0), 0.0, "coarse"),
        (errors(0.0, 10.0), 0.0, "off"),
        (errors(0.0, 0.0, 4.99), 0.0, "fine"),
        (errors(0.0, 0.0, 5.0), 0.0, "coarse"),
        (errors(0.0, 0.0, 10.0), 0.0, "off"),
        (errors(0.023), 0.02, "fine"),  # below 1.2 residuals
        (errors(0.024), 0.02, "right"),
        (errors(0.0399), 0.02, "right"),  # below 2 residuals
        (errors(0.04), 0.02, "coarse"),
        (errors(0.0, reflected=True), 0.02, "off"),
    ],
)
def test_thresholds_hold_at_their_edges(measured, residual, expected):
    assert grade(measured, residual) == expected


@pytest.mark.parametrize(
    ("related", "overlap", "expected"),
    [
        (False, 0.9, "unrelated"),
        (False, None, "unrelated"),
        (True, 0.0499, "unrelated"),
        (True, 0.05, "optional"),
        (True, 0.1499, "optional"),
        (True, 0.15, "required"),
        (True, None, "required"),
    ],
)
def test_strata_follow_the_overlap(related, overlap, expected):
    assert stratum_of(related, overlap) == expected


@pytest.mark.parametrize(
    ("verdict", "grades", "stratum", "expected"),
    [
        ("accepted", ["right"], "required", "right-accepted"),
        ("accepted", ["fine", "off"], "optional", "right-accepted"),
        ("accepted", ["coarse"], "required", "wrong-accepted"),
        ("accepted", ["off", "fine"], "required", "wrong-accepted"),
        ("accepted", [], "unrelated", "wrong-accepted"),
        ("accepted", ["fine"], "unrelated", "wrong-accepted"),
        ("ambiguous", ["off", "off", "off", "off", "right"], "required", "ambiguous-with-truth"),
        ("ambiguous", ["off", "off", "off", "off", "off", "right"], "required", "ambiguous-without-truth"),
        ("ambiguous", ["coarse"], "required", "ambiguous-without-truth"),
        ("ambiguous", [], "unrelated", "ambiguous-without-truth"),
        ("rejected", ["fine"], "required", "rejected"),
        ("rejected", [], "unrelated", "rejected"),
    ],
)
def test_outcomes_are_named_by_verdict_and_truth(verdict, grades, stratum, expected):
    assert outcome_of(verdict, grades, stratum) == expected
