import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.robust.directions import direction_energies, dominant_angles
from rectmerge.robust.features import rectangles_in_frame
from rectmerge.robust.params import Params
from rectmerge.robust.proposal import propose_all_round, propose_by_correlation, propose_by_rectangles, propose_rivals
from rectmerge.robust.ranking import rank, rerank
from rectmerge.robust.refinement import to_pixels
from rectmerge.robust.wall_agreement import AgreementScorer
from rectmerge.robust.working_pair import WorkingPair
from tests.rectmerge.robust import naive, plans
from tests.rectmerge.robust.plans import as_similarity

PARAMS = Params()


def searched(a, b, *, bounds=(0.3, 3.0), seed=0):
    """Propose by rectangles with the default numbers; return the working pair and its ranking."""
    maps = plans.prepared(a.grid), plans.prepared(b.grid)
    features_a, features_b = (map_.walled for map_ in maps)
    rng = np.random.default_rng(seed)
    angle, angle_b = (map_.angles[0][0] for map_ in maps)
    working = WorkingPair(
        a=features_a,
        b=features_b,
        walls_a=rng.permutation(features_a.walls),
        walls_b=rng.permutation(features_b.walls),
        scale_bounds=bounds,
        angle=angle,
        angle_b=angle_b,
        scorer=AgreementScorer(
            (features_a, features_b), (maps[0].detailed, maps[1].detailed), (angle, angle_b), PARAMS
        ),
        handicap=0.0,
        params=dataclasses.replace(PARAMS, propose=dataclasses.replace(PARAMS.propose, max_refined=120)),
    )
    prepare = dataclasses.replace(PARAMS.prepare, max_rectangles=200)
    frames = [
        [rectangles_in_frame(each, angle, prepare) for angle, _ in dominant_angles(each, prepare)]
        for each in (features_a, features_b)
    ]
    return working, rank(working, propose_by_rectangles(working, *frames))


def pair(noise=0, cut=1.0, seed=0):
    rooms = plans.office(seed)
    a = plans.see(rooms, degrees=33, window=(-8, -8, 300 * cut + 8, 236), noise=noise, seed=1)
    b = plans.see(rooms, degrees=190, scale=0.8, window=(300 * (1 - cut), -8, 316, 236), noise=noise, seed=2)
    return a, b


def test_the_truth_comes_first_and_the_rest_is_ranked_and_distinct():
    a, b = pair(noise=1, cut=0.7)

    working, ranking = searched(a, b)

    best = as_similarity(to_pixels(ranking.placements[0], working.a, working.b))
    assert plans.is_right(best, a, b)
    assert 1 < len(ranking.placements) <= PARAMS.rank.max_ranked
    assert (np.diff(ranking.plausibility) <= 0).all()
    places = [naive.move(placement, working.b.landmarks) for placement in ranking.placements]
    apart = [np.abs(p - q).max() for i, p in enumerate(places) for q in places[:i]]
    assert min(apart) >= PARAMS.rank.same_radius_share * working.a.radius


def test_a_likelier_placement_between_two_counts_once():
    working, ranking = searched(*pair(noise=1))
    apart = max(PARAMS.rank.same_fit_cells, PARAMS.rank.same_radius_share * working.a.radius)
    beside = np.array([[0, 0, side * 0.7 * apart, 0] for side in (-1, 0, 1)])
    three = ranking.take(np.zeros(3, np.intp))
    likelihood = np.array([1.0, 2.0, 1.0])
    odds = np.array([5.0, 4.9, 5.0])
    placements = three.placements + beside

    kept = rerank(working, replace(three, placements=placements, likelihood=likelihood, rigid=odds, bent=odds))

    np.testing.assert_array_equal(kept.placements, placements[1:2])


def test_the_truth_is_the_only_plausible_placement():
    _, ranking = searched(*pair(noise=1))

    assert ranking.plausibility[0] > 3
    assert (ranking.plausibility[1:] < ranking.plausibility[0] - 3).all()
    assert ranking.agreement.matched[0] > 0.9
    assert ranking.agreement.contradicted[0] < 0.05
    assert ranking.agreement.violations[0] < 0.05
    assert ranking.agreement.overlap[0] > 0.95
    assert ranking.support[0] > ranking.support[1]


def test_every_shift_finds_the_truth_without_a_rectangle():
    a, b = pair(noise=1, cut=0.6)
    working, _ = searched(a, b)
    angles = [
        [angle for angle, _ in dominant_angles(features, PARAMS.prepare)[:1]] for features in (working.a, working.b)
    ]

    ranking = rank(working, propose_by_correlation(working, *angles))

    assert plans.is_right(as_similarity(to_pixels(ranking.placements[0], working.a, working.b)), a, b)


@pytest.mark.parametrize("off_deg", [9, 12, 23])  # between two angles that are tried, on one, and near one
def test_angles_all_round_find_the_truth_whatever_the_strongest_direction(off_deg):
    a, b = pair(noise=1, cut=0.6)
    working, _ = searched(a, b, bounds=(0.5, 2.0))
    energies = [direction_energies(each, PARAMS.prepare) for each in (working.a, working.b)]

    placements = propose_all_round(replace(working, angle=working.angle + np.radians(off_deg)), *energies)
    ranking = rank(working, placements)

    assert plans.is_right(as_similarity(to_pixels(ranking.placements[0], working.a, working.b)), a, b)


@pytest.mark.parametrize("shift", [0, 60])
def test_rivals_of_a_placement_hold_the_truth_if_it_has_the_same_scale(shift):
    a, b = pair(noise=1)
    working, ranking = searched(a, b)
    beside = ranking.placements[0] + np.array([0, 0, shift, 0])

    rivals = rank(working, propose_rivals(working, beside))

    assert plans.is_right(as_similarity(to_pixels(rivals.placements[0], working.a, working.b)), a, b)


def test_joined_rankings_keep_the_best_of_both():
    working, ranking = searched(*pair(noise=1))
    halves = [ranking.take(np.arange(start, len(ranking), 2)) for start in (0, 1)]

    joined = rerank(working, halves[1].concat(halves[0]))

    np.testing.assert_array_equal(joined.placements, ranking.placements)
    np.testing.assert_allclose(joined.plausibility, ranking.plausibility, rtol=1e-9)


def test_no_scale_within_bounds_no_ranking():
    a, b = pair()

    _, ranking = searched(a, b, bounds=(30.0, 31.0))

    assert len(ranking) == 0


def test_the_overlap_of_the_working_grids_is_that_of_the_maps():
    a, b = pair(cut=0.7)
    _, ranking = searched(a, b)

    wanted = measure_agreement(a.grid, b.grid, plans.truth(a, b))

    assert (ranking.agreement.overlap[0], ranking.agreement.iou[0]) == pytest.approx(
        (wanted.overlap, wanted.iou), abs=0.03
    )
