import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge._kernels.shrinking import known_bounds, shrink
from rectmerge.robust import hypotheses
from scenarios.ablation import ABLATIONS, Ablation, ablated_rows, shrink_with_specks
from tests.scenarios.made import pair


@pytest.mark.parametrize("ablation", ABLATIONS[1:], ids=lambda ablation: ablation.name)
def test_an_ablation_changes_the_method_and_takes_it_back(ablation):
    before = [getattr(module, name) for module, name, _ in ablation.patches]

    with ablation.applied() as contender:
        changed = [getattr(module, name) for module, name, _ in ablation.patches]
        assert all(new is not old for new, old in zip(changed, before, strict=True))
        assert all(getattr(contender.method, field) == value for field, value in ablation.fields)

    assert ablation.patches or ablation.fields
    assert [getattr(module, name) for module, name, _ in ablation.patches] == before


def test_a_change_is_taken_back_when_the_body_fails():
    plenty = hypotheses.PLENTY

    with pytest.raises(ZeroDivisionError), Ablation(name="x", patches=((hypotheses, "PLENTY", 7),)).applied():
        raise ZeroDivisionError

    assert plenty == hypotheses.PLENTY


def test_a_change_of_what_is_not_there_is_an_error():
    with pytest.raises(AttributeError), Ablation(name="x", patches=((hypotheses, "NO_SUCH", 7),)).applied():
        pass
    assert not hasattr(hypotheses, "NO_SUCH")


def test_no_two_names_are_alike():
    assert len({ablation.name for ablation in ABLATIONS}) == len(ABLATIONS)


def test_every_ablated_method_answers_without_failing():
    for ablation in ABLATIONS:
        (row,) = ablated_rows(ablation, [pair()])

        assert row["method"] == ablation.name
        assert row["verdict"] in ("accepted", "ambiguous", "rejected"), row["reason"]


@given(st.integers(0, 999), st.sampled_from([1.0, 1.3, 2.0, 3.7]))
def test_shrinking_with_specks_is_the_kernel_where_there_are_none(seed, factor):
    rng = np.random.default_rng(seed)
    cells = np.full((40, 50), -1, np.int8)
    cells[5:33, 4:47] = 0
    for _ in range(6):
        cells[rng.integers(5, 33), 4:47] = 100  # walls from end to end, which touch the unknown
    cells[rng.integers(0, 40, 30), rng.integers(0, 50, 30)] = -1

    ours, theirs = (way(cells, known_bounds(cells), factor) for way in (shrink_with_specks, shrink))

    for mine, kernel in zip(ours[:5], theirs[:5], strict=True):
        np.testing.assert_array_equal(mine, kernel)
    assert theirs[5] == 0


def test_shrinking_with_specks_keeps_a_lone_cell_that_the_kernel_drops():
    cells = np.zeros((9, 9), np.int8)
    cells[0] = 100
    cells[5, 6] = 100

    kept, dropped = (way(cells, known_bounds(cells), 1.0) for way in (shrink_with_specks, shrink))

    assert (kept[1][5, 6], dropped[1][5, 6]) == (1, 0)
    assert (kept[2][5, 6], kept[3][5, 6], kept[4][5, 6]) == (1, 6.0, 5.0)
