import pytest

from rectmerge.errors import MethodError
from rectmerge.methods import make_method
from scenarios.studies.ablation import ABLATIONS, Ablation, ablated_rows
from tests.scenarios.known_answers import pair


@pytest.mark.parametrize("ablation", ABLATIONS[1:], ids=lambda ablation: ablation.name)
def test_an_ablation_changes_the_method(ablation):
    assert ablation.contender().method != make_method("robust")


def test_the_first_row_is_the_method_as_it_is():
    assert ABLATIONS[0].contender().method == make_method("robust")


def test_a_change_of_a_field_that_is_not_there_is_an_error():
    with pytest.raises(MethodError, match="no field 'no_such'"):
        Ablation(name="x", fields={"propose.no_such": 7}).contender()


def test_no_two_names_are_alike():
    assert len({ablation.name for ablation in ABLATIONS}) == len(ABLATIONS)


@pytest.mark.slow
def test_every_ablated_method_answers_without_failing():
    for ablation in ABLATIONS:
        (row,) = ablated_rows(ablation, [pair()])

        assert row["method"] == ablation.name
        assert row["verdict"] in ("accepted", "ambiguous", "rejected"), row["reason"]
