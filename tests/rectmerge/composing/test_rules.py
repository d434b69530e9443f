from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rectmerge.composing.rules import RULES, combine_evidence, merge_layers
from rectmerge.errors import InputError

cells = arrays(np.int8, (2, 3), elements=st.integers(-1, 100))


def one(*values, reliability=0.9):
    merged, mass = combine_evidence([np.full((1, 1), v, np.int8) for v in values], reliability=reliability)
    return int(merged[0, 0]), float(mass[0, 0])


def by_the_book(values, reliability):
    """Combine masses (free, occupied, either) one after the other, normalising each time; return occupancy and mass."""
    free, occupied, either, agreed = 0.0, 0.0, 1.0, 1.0
    for value in values:
        belief = 0.0 if value < 0 else reliability * (2 * value / 100 - 1)
        f, o, e = max(-belief, 0.0), max(belief, 0.0), 1 - abs(belief)
        conflict = free * o + occupied * f
        agreed *= 1 - conflict
        free, occupied, either = (
            m / (1 - conflict) for m in (free * (f + e) + either * f, occupied * (o + e) + either * o, either * e)
        )
    return 100 * (occupied + either / 2), 1 - agreed


@given(st.lists(st.integers(0, 100), min_size=2, max_size=6), st.floats(0.1, 0.95))
def test_evidence_is_dempsters_rule(values, reliability):
    occupancy, mass = one(*values, reliability=reliability)

    expected, conflict = by_the_book(values, reliability)
    assert occupancy == pytest.approx(expected, abs=0.501)
    assert mass == pytest.approx(conflict, abs=1e-5)


@given(st.lists(cells, min_size=2, max_size=4))
def test_the_order_of_maps_does_not_matter_to_evidence(layers):
    merged, mass = combine_evidence(layers)

    for order in permutations(layers):
        other, other_mass = combine_evidence(order)
        assert np.abs(other - merged).max() <= 1  # rounding to whole per cent
        np.testing.assert_allclose(other_mass, mass, atol=1e-5)


@given(st.lists(cells, min_size=1, max_size=4), st.integers(0, 4))
def test_a_map_that_knows_nothing_changes_nothing(layers, at):
    blank = np.full((2, 3), -1, np.int8)

    for rule in RULES:
        merged, _ = merge_layers(layers, rule)
        other, _ = merge_layers([*layers[:at], blank, *layers[at:]], rule)
        assert (merged == other).all()


@given(cells)
def test_a_cell_that_one_map_knows_keeps_its_value_and_is_no_conflict(layer):
    merged, mass = combine_evidence([np.full((2, 3), -1, np.int8), layer])

    assert (merged == layer).all()
    assert not mass.any()


def test_equal_contradiction_is_unknown_and_the_majority_wins():
    assert one(100, 0) == (50, pytest.approx(0.81, abs=1e-6))
    assert one(100, 0, 0)[0] <= 25
    assert one(100, 100, 0)[0] >= 65
    assert one(100, 50) == (95, 0.0)  # a cell at 50 says nothing, so that one mass of 0.9 is left


def test_evidence_of_very_many_maps_does_not_vanish():
    occupancy, mass = one(*[0, 100] * 60)

    assert occupancy == 50
    assert mass == pytest.approx(1.0)


@pytest.mark.parametrize("reliability", [0.0, 1.0, -0.5, float("nan")])
def test_a_reliability_that_cannot_be_is_refused(reliability):
    with pytest.raises(InputError, match="reliability"):
        one(0, reliability=reliability)


@given(st.lists(cells, min_size=2, max_size=4))
def test_the_newest_map_that_knows_a_cell_wins(layers):
    merged, _ = merge_layers(layers, "newest")

    known = [(layer >= 0) & ((layer <= 25) | (layer >= 65)) for layer in layers]
    for where in np.argwhere(np.any(known, axis=0)):
        last = max(i for i, mask in enumerate(known) if mask[tuple(where)])
        assert merged[tuple(where)] == layers[last][tuple(where)]


def test_the_snippet_of_the_page_on_composing_runs(monkeypatch, capsys):
    root = Path(__file__).parents[3]
    monkeypatch.chdir(root)
    snippet = (root / "docs" / "composing.md").read_text().split("```python\n")[1].split("```")[0]

    exec(compile(snippet, "composing.md", "exec"), {})

    assert "of the cells are in doubt" in capsys.readouterr().out
