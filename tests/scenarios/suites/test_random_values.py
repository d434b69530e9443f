import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from scenarios.suites.random_values import extreme_values, has_random_values, sample_values

TABLE = {
    "overlap": {"from": 0.15, "to": 1.0},
    "ratio": {"from": 0.5, "to": 2.0, "log": True},
    "rooms": {"from": 6, "to": 9},
    "poses": {"any_of": ["truth", "slam"]},
    "family": {"in_turn": ["office", "loop", "hall"]},
    "size_m": [{"from": 10.0, "to": 20.0}, 12.0],
    "world": {"any_of": [{"family": "office", "rooms": {"from": 6, "to": 12}}, {"family": "hall"}]},
}


def many(table, count=400, **options):
    return [sample_values(table, name="some", seed=seed, **options) for seed in range(count)]


@given(st.integers(0, 10**9))
def test_the_same_seed_and_name_draw_the_same_values_and_others_draw_others(seed):
    once = sample_values(TABLE, name="some", seed=seed)

    assert sample_values(TABLE, name="some", seed=seed) == once
    assert sample_values(TABLE, name="other", seed=seed)["overlap"] != once["overlap"]
    assert sample_values(TABLE, name="some", seed=seed + 1)["overlap"] != once["overlap"]
    assert not has_random_values(once)


def test_values_keep_their_ranges_and_fill_them():
    values = many(TABLE)

    overlaps = [value["overlap"] for value in values]
    assert 0.15 <= min(overlaps) < 0.2
    assert 0.95 < max(overlaps) <= 1.0
    assert {value["rooms"] for value in values} == {6, 7, 8, 9}
    assert {value["poses"] for value in values} == {"truth", "slam"}
    assert {value["world"].get("rooms", 0) for value in values} == {0, *range(6, 13)}
    assert all(10.0 <= value["size_m"][0] <= 20.0 and value["size_m"][1] == 12.0 for value in values)


def test_halves_are_as_likely_as_doubles_on_a_logarithmic_scale():
    ratios = [value["ratio"] for value in many(TABLE, 1000)]

    assert 0.5 <= min(ratios) < max(ratios) <= 2.0
    assert abs(sum(math.log(ratio) for ratio in ratios) / len(ratios)) < 0.05


def test_choices_in_turn_begin_with_the_first_seed():
    families = [sample_values(TABLE, name="some", seed=seed, first=5)["family"] for seed in range(5, 9)]

    assert families == ["office", "loop", "hall", "office"]


def test_every_key_draws_from_a_stream_of_its_own():
    changed = {
        **TABLE,
        "rooms": 7,
        "poses": {"any_of": ["truth", "slam", "odometry"]},
        "more": {"from": 0.0, "to": 1.0},
    }

    for before, after in zip(many(TABLE, 20), many(changed, 20), strict=True):
        for key in ("overlap", "ratio", "family", "size_m", "world"):
            assert before[key] == after[key]
    assert all(value["more"] != value["overlap"] for value in many(changed, 20))


def test_corners_show_both_ends_and_every_choice():
    tables = list(extreme_values(TABLE))

    assert {table["overlap"] for table in tables} == {0.15, 1.0}
    assert {table["rooms"] for table in tables} == {6, 9}
    assert {table["family"] for table in tables} == {"office", "loop", "hall"}
    assert list(extreme_values({"rooms": 6})) == [{"rooms": 6}]


@pytest.mark.parametrize(
    ("draw", "complaint"),
    [
        ({"from": 1.0, "to": 0.5}, "a.b: from must be less than to, got 1.0 and 0.5"),
        ({"from": 1.0, "to": 1.0}, "a.b: from must be less than to"),
        ({"from": 1.0}, "a.b.to: missing"),
        ({"to": 1.0}, "a.b.from: missing"),
        ({"from": "x", "to": 1.0}, "a.b.from: must be a number, got 'x'"),
        ({"from": 0.0, "to": float("inf")}, "a.b.to: must be a number, got inf"),
        ({"from": True, "to": 2}, "a.b.from: must be a number, got True"),
        ({"from": 0.0, "to": 1.0, "log": True}, "a.b: from must be > 0 with log = true, got 0.0"),
        ({"from": 0.5, "to": 1.0, "log": 1}, "a.b.log: must be true or false, got 1"),
        ({"from": 0.5, "to": 1.0, "step": 1}, "a.b: unknown key 'step' with from, to"),
        ({"any_of": []}, "a.b.any_of: must list the choices, got []"),
        ({"any_of": "truth"}, "a.b.any_of: must list the choices, got 'truth'"),
        ({"in_turn": [1], "any_of": [2]}, "a.b: unknown key 'in_turn' with any_of"),
        ({"in_turn": [1], "to": 2}, "a.b: unknown key 'to' with in_turn"),
        ([{"in_turn": [{"from": 2.0, "to": 1.0}]}], "a.b[0]: from must be less than to"),
    ],
)
def test_a_draw_of_no_known_form_is_refused_with_its_path(draw, complaint):
    with pytest.raises(InputError) as refused:
        sample_values({"a": {"b": draw}}, name="some", seed=0)

    assert str(refused.value).startswith(complaint)
