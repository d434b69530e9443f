import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.analysis.trinary_map import MapCells
from rectmerge.errors import InputError
from rectmerge.robust.certificate import certify
from rectmerge.robust.face_score import PADDING, FaceScore, total
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import Params
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
ROW = [*(plans.box(40 * i, 0, 34, 50) for i in range(8)), *(plans.box(40 * i + 33, 20, 8, 10) for i in range(7))]


def office_pair() -> tuple[plans.PlanView, plans.PlanView, Similarity]:
    a = plans.see(plans.office(3), degrees=20, noise=1, seed=1)
    b = plans.see(plans.office(3), degrees=70, scale=1.1, window=(-8, -8, 200, 236), noise=1, seed=2)
    return a, b, a.pixels.inverse() @ b.pixels


@pytest.fixture(scope="module")
def office_score() -> FaceScore:
    a, b, pixels = office_pair()
    features = [extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b)]
    return FaceScore.from_placement(features[0], features[1], pixels, PARAMS)


def random_boxes(score: FaceScore, rng: np.random.Generator, count: int, largest_cells: float):
    """Draw boxes about the accepted placement and anywhere, of all sizes."""
    height, width = score.a.free.shape
    angles = score.given[0] + rng.integers(-1, 3, count) * np.pi / 2 + rng.uniform(-0.6, 0.6, count)
    anywhere = np.column_stack([angles, rng.uniform(-0.7, 0.7, count), rng.uniform(-60, [width, height], (count, 2))])
    middles = np.where(rng.random((count, 1)) < 0.3, score.given, anywhere)
    size = largest_cells * rng.random((count, 3)) ** 3
    return np.column_stack([middles, np.minimum(size[:, :2] / score.b.radius, 0.15), size[:, 2]])


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.6, 4.0, 60.0]))
def test_no_placement_in_a_box_scores_more_than_its_bound(office_score, seed, largest_cells):
    rng = np.random.default_rng(seed)
    boxes = random_boxes(office_score, rng, 20, largest_cells)
    inside = np.repeat(boxes, 40, axis=0)
    corners = rng.choice([-1.0, 0.0, 1.0], (len(inside), 4))
    offsets = np.where(rng.random((len(inside), 1)) < 0.5, corners, rng.uniform(-1, 1, (len(inside), 4)))
    placements = inside[:, :4] + offsets * inside[:, [4, 5, 6, 6]]
    shares = office_score.unbounded(len(boxes))

    office_score.lower(boxes, shares, -(1 << 40))

    scores = office_score.of_placements(placements).reshape(len(boxes), -1)
    assert (scores <= total(shares)[:, None]).all()


def test_a_box_of_one_placement_is_bounded_by_its_score(office_score):
    boxes = random_boxes(office_score, np.random.default_rng(0), 50, 0.0)
    shares = office_score.unbounded(len(boxes))

    office_score.lower(boxes, shares, -(1 << 40))

    assert total(shares).tolist() == office_score.of_placements(boxes[:, :4]).tolist()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_scores_are_those_of_a_slow_loop(office_score, seed):
    placements = random_boxes(office_score, np.random.default_rng(seed), 5, 1.0)[:, :4]
    quarters = np.rint((placements[:, 0] - office_score.given[0]) / (np.pi / 2)).astype(int)
    fields = [gains[0, :, PADDING:, PADDING:] for gains in office_score.gains]
    common = office_score.groups, office_score.faces, office_score.centre, *fields

    scores = office_score.of_placements(placements)

    slow = [naive.face_score(placement, q, *common) for placement, q in zip(placements, quarters, strict=True)]
    assert scores.tolist() == slow


def test_bounds_that_are_known_already_never_rise(office_score):
    boxes = random_boxes(office_score, np.random.default_rng(1), 50, 30.0)
    known = np.random.default_rng(2).integers(-500, 500, (50, len(office_score.groups))).astype(np.int16)
    shares = known.copy()

    office_score.lower(boxes, shares, 300)

    assert (shares <= known).all()
    assert (shares[total(known) < 300] == known[total(known) < 300]).all()


def test_a_distinctive_office_is_certified():
    a, b, pixels = office_pair()

    certificate = certify(a.grid, b.grid, pixels, scale=(1.08, 1.12), seconds=120, params=PARAMS)

    assert certificate
    assert certificate.counterexample is None
    assert 0 < certificate.best_elsewhere < (1 - certificate.margin) * certificate.score
    assert str(certificate).startswith("yes: nothing elsewhere scores 90%")
    assert {"certified", "margin", "score", "best_elsewhere", "seconds", "boxes"} <= set(certificate.as_dict())


def test_a_row_of_identical_cells_is_not_and_what_scores_alike_is_shown():
    a, b = plans.see(ROW), plans.see(ROW, degrees=30, window=(-8, -8, 168, 66))
    pixels = a.pixels.inverse() @ b.pixels

    certificate = certify(a.grid, b.grid, pixels, scale=(0.98, 1.02), seconds=120, params=PARAMS)

    assert not certificate
    assert certificate.counterexample is not None
    middle = np.array(b.grid.shape[::-1]) / 2
    landmarks = middle + np.array([[90.0, 0.0], [0.0, 90.0], [-90.0, 0.0], [0.0, -90.0]])
    moved = np.hypot(*(certificate.counterexample.apply(landmarks) - pixels.apply(landmarks)).T).max()
    assert moved > PARAMS.certificate.away_share * np.hypot(*(np.ptp(np.argwhere(a.grid.occupancy >= 0), axis=0) + 1))
    features = [extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b)]
    alone = FaceScore.from_placement(features[0], features[1], certificate.counterexample, PARAMS).accepted / 32
    assert certificate.counterexample_score >= (1 - certificate.margin) * certificate.score
    assert alone > 0.75 * certificate.score  # scored anew, with ways counted from the other placement


@pytest.mark.slow
def test_the_time_limit_ends_the_search_and_the_gap_is_told():
    a, b, pixels = office_pair()

    certificate = certify(a.grid, b.grid, pixels, scale=(0.5, 2.0), seconds=0.3, params=PARAMS)

    assert not certificate
    assert certificate.best_elsewhere > (1 - certificate.margin) * certificate.score
    assert "not in time" in str(certificate)


def test_a_placement_no_better_than_chance_is_not_certified():
    a, b, pixels = office_pair()

    certificate = certify(
        a.grid, b.grid, pixels @ Similarity(1.0, 0.4, 31.0, 17.0), scale=(1.0, 1.2), seconds=10.0, params=PARAMS
    )

    assert not certificate
    assert certificate.counterexample is None or certificate.score > 0


def test_bad_words_are_refused():
    a, b, pixels = office_pair()

    with pytest.raises(InputError, match="seconds must be > 0"):
        certify(a.grid, b.grid, pixels, scale=(0.5, 2.0), seconds=0.0, params=PARAMS)
    with pytest.raises(InputError, match="scale must satisfy"):
        certify(a.grid, b.grid, pixels, scale=(2.0, 0.5), seconds=10.0, params=PARAMS)
