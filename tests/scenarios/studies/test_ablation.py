import numpy as np
import pytest

from rectmerge._kernels.wall_cells import SPECK, SURFACE, describe_walls
from rectmerge.robust import hypotheses
from scenarios.studies.ablation import ABLATIONS, Ablation, ablated_rows, no_specks
from tests.scenarios.known_answers import pair


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


def test_without_the_removal_of_specks_a_lone_cell_is_a_wall():
    values = np.zeros((9, 9), np.int8)
    values[0] = 100
    values[5, 6] = 100
    occupied = np.flatnonzero(values > 0)

    kept, dropped = (dict(zip(occupied, way(values, occupied)[0], strict=True)) for way in (no_specks, describe_walls))

    assert (kept[5 * 9 + 6], dropped[5 * 9 + 6]) == (SURFACE, SPECK)
    assert {kept[c] for c in range(9)} == {dropped[c] for c in range(9)} == {SURFACE}
