import numpy as np
import pytest

from scenarios.bench.mistakes import MISTAKES, name_mistake
from scenarios.pairs.drawn_pairs import easy_pairs
from scenarios.scoring.score import measure_errors
from tests.scenarios.mistaken_methods import mistaken_matrix


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.name)
@pytest.mark.parametrize("pair", easy_pairs(), ids=lambda pair: pair.pair_id)
def test_a_mistake_undone_is_the_right_answer(mistake, pair):
    meant = mistake.undone(mistaken_matrix(mistake.name, pair), pair)

    assert measure_errors(meant, pair).e_px < 0.3
    assert not measure_errors(meant, pair).reflected


@pytest.mark.parametrize("name", ["none", "lost"])
def test_no_mistake_is_named_where_answers_are_right_or_nothing_explains_them(name):
    assert name_mistake([(pair, mistaken_matrix(name, pair)) for pair in easy_pairs()]) is None


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.name)
def test_a_mistake_is_named_though_one_answer_is_lost(mistake):
    first, *others = easy_pairs()
    answers = [
        (first, mistaken_matrix("lost", first)),
        *((pair, mistaken_matrix(mistake.name, pair)) for pair in others),
    ]

    named = name_mistake(answers)

    assert named is mistake


def test_right_answers_that_are_coarse_are_no_mistake():
    rng = np.random.default_rng(0)

    for _ in range(20):
        off = [np.pad(rng.normal(0, 0.7, (2, 1)), ((0, 0), (2, 0))) for _ in easy_pairs()]
        answers = [(pair, mistaken_matrix("none", pair) + shift) for pair, shift in zip(easy_pairs(), off, strict=True)]
        assert name_mistake(answers) is None


def test_one_answer_names_nothing():
    pair = easy_pairs()[1]

    assert name_mistake([(pair, mistaken_matrix("inverse", pair))]) is None
    assert name_mistake([]) is None
