import pytest

from rectmerge.errors import InputError
from scenarios.bench.contenders import make_contenders
from scenarios.bench.entrants import Entrant, contenders, entrants, entrants_named
from scenarios.leaderboard.tuning import as_table, best_threshold, tuned_contender
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


@pytest.mark.parametrize(
    ("answers", "accept_at", "worth"),
    [
        ([(0.9, "right"), (0.7, "off")], 0.8, 1),
        ([(0.9, "off"), (0.7, "right")], 0.35, 0),
        ([(0.9, "fine"), (0.7, "right")], 0.35, 2),
        ([(0.9, None), (0.7, "right"), (0.6, "right"), (0.5, "right")], 0.25, 2),  # of two places: wrong
        ([(0.9, "right"), (0.9, "off"), (0.1, "right"), (None, None)], 0.05, 1),
        ([(0.8, "off")], 0.4, -1),
    ],
)
def test_the_threshold_is_where_right_less_wrong_is_most(answers, accept_at, worth):
    threshold = best_threshold([row(*answer) for answer in answers])

    assert (threshold.accept_at, threshold.worth) == (pytest.approx(accept_at), worth)


def test_the_configuration_that_is_worth_most_is_taken_with_its_threshold():
    ways = OPEN.configurations(2)
    rows = [row(0.5, "off"), row(0.4, "right"), row(8.0, "right", "some-1"), row(4.0, "off", "some-1")]

    taken = tuned_contender(OPEN, ways, rows)

    assert (taken.label, taken.method) == ("some-tuned", "paper")
    assert taken.set == {**ways[1].set, "accept_at": 6.0}
    assert structure(as_table([taken])["contenders"], list[type(taken)]) == [taken]


def test_a_method_that_tells_no_score_cannot_be_tuned():
    with pytest.raises(InputError, match="no answer has a score"):
        tuned_contender(OPEN, OPEN.configurations(1), [row(None, None)])


@pytest.mark.parametrize("label", ["robust", "nobody"])
def test_who_has_nothing_to_tune_is_refused(label):
    with pytest.raises(InputError, match=f"'{label}' cannot be tuned"):
        entrants_named([label])
