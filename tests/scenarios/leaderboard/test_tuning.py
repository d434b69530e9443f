import pytest

from rectmerge.errors import InputError
from scenarios.bench.contenders import make_contenders
from scenarios.bench.entrants import Entrant, contenders, entrants, entrants_named
from scenarios.leaderboard.tuning import ScoredAnswers, as_table, tuned_contender
from scenarios.suites.toml_tables import structure

OPEN = Entrant(
    label="some", method="paper", set={"inclusive_sides": True}, space={"delta_cells": {"from": 1.0, "to": 9.0}}
)


def row(score, grade, label="some-0"):
    grades = [grade] if grade else []
    return {"method": label, "evidence": [] if score is None else [{"score": score}], "grades": grades}


def test_all_that_take_part_can_be_made_and_have_labels_of_their_own():
    everybody = contenders()

    made = make_contenders([entry.label for entry in everybody], everybody)

    assert len({entry.label for entry in made}) == len(everybody)
    assert {"robust", "paper"} <= {entry.label for entry in made}


def test_every_configuration_of_every_entrant_can_be_made():
    for entrant in entrants():
        ways = entrant.configurations(5)
        assert len(make_contenders([entry.label for entry in ways], ways)) == 5


def test_the_first_configuration_is_the_authors_own_and_a_budget_holds_those_of_a_smaller_one():
    ways = OPEN.configurations(6)

    assert ways[0].set == {"inclusive_sides": True}
    assert len({entry.set["delta_cells"] for entry in ways[1:]}) == 5
    assert all(entry.set["inclusive_sides"] for entry in ways)
    assert OPEN.configurations(3) == ways[:3]


def read(answers):
    return ScoredAnswers.from_rows([row(*answer) for answer in answers])


@pytest.mark.parametrize(
    ("answers", "area"),
    [
        ([(0.9, "right"), (0.7, "off")], 0.25),
        ([(0.9, "off"), (0.7, "right")], 0.75),
        ([(0.9, "fine"), (0.7, "right")], 0.0),
        ([(0.9, None), (0.7, "right")], 0.75),  # of two places: wrong
        ([(0.9, "right"), (None, None)], 0.25),  # no answer: wrong, and last
        ([(0.5, "right"), (0.5, "off")], 0.5),  # equally sure
    ],
)
def test_the_area_is_the_mean_share_that_is_wrong_of_the_best_scored(answers, area):
    assert read(answers).aurc() == pytest.approx(area)


MANY = [(1.5, "right")] * 4 + [(0.8, "right")] * 9 + [(0.3, "off")] * 4


@pytest.mark.parametrize(
    ("answers", "own", "accept_at"),
    [
        (MANY, 1.0, 0.55),  # nine more that are right
        ([*MANY, *[(0.8, "off")] * 9], 1.0, 1.0),  # as many wrong
        ([*MANY[:4], (1.2, "off")], 1.0, 1.0),  # one pair decides nothing
        ([*MANY[:4], *[(1.2, "off")] * 9], 1.0, 1.35),
        ([(0.0, "off"), (None, None)], 1.0, 1.0),
    ],
)
def test_a_threshold_changes_only_where_it_is_surely_better(answers, own, accept_at):
    assert read(answers).threshold(own) == pytest.approx(accept_at)


OPEN_KEYPOINTS = Entrant(label="some", method="keypoints", space={"match_conf": {"from": 0.1, "to": 0.5}})


def test_the_configuration_of_the_least_area_is_taken():
    ways = OPEN_KEYPOINTS.configurations(2)
    rows = [row(2.0, "off"), row(1.5, "right"), row(1.5, "right", "some-1"), row(1.2, "off", "some-1")]

    taken = tuned_contender(OPEN_KEYPOINTS, ways, rows)

    assert (taken.label, taken.method, taken.set) == ("some-tuned", "keypoints", ways[1].set)
    assert structure(as_table([taken])["contenders"], list[type(taken)]) == [taken]


def test_the_authors_parameters_and_threshold_stay_where_nothing_is_better():
    ways = OPEN_KEYPOINTS.configurations(2)
    rows = [row(1.4, "right", f"some-{k}") for k in (0, 1)] + [row(1.2, "off", f"some-{k}") for k in (0, 1)]

    assert tuned_contender(OPEN_KEYPOINTS, ways, rows).set == {}


def test_a_threshold_that_is_better_goes_with_the_configuration():
    ways = OPEN_KEYPOINTS.configurations(1)

    assert tuned_contender(OPEN_KEYPOINTS, ways, [row(*answer) for answer in MANY]).set == {"accept_at": 0.55}


def test_a_method_that_tells_no_score_cannot_be_tuned():
    with pytest.raises(InputError, match="no answer has a score"):
        tuned_contender(OPEN, OPEN.configurations(1), [row(None, None)])


@pytest.mark.parametrize("label", ["robust", "nobody"])
def test_who_has_nothing_to_tune_is_refused(label):
    with pytest.raises(InputError, match=f"'{label}' cannot be tuned"):
        entrants_named([label])
