"""What suites leave open, share among their scenarios, and make of one mission."""

from dataclasses import replace

import pytest

from rectmerge.errors import ScenarioError, SimulationError
from scenarios.suites.suite import load_suite
from tests.scenarios.suites.test_suite import written

OPEN = """
title = "Open"
[base]
world = { size_m = [20.0, 13.0], rooms = { from = 6, to = 9 } }
a = { resolution = { from = 0.04, to = 0.06 }, turn_deg = "random" }
mission = { overlap = { from = 0.3, to = 0.9 }, rays = "compiled" }
[[scenarios]]
name = "drawn"
seeds = { first = 4, count = 6 }
split = { in_turn = ["train", "test"] }
ratio = { from = 0.5, to = 2.0, log = true }
noise = [{ any_of = [0, 1] }, 2]
[[scenarios]]
name = "ways"
world = { rooms = 8 }
mission = { overlap = 0.5 }
ratio = 1.2
variants = [
    { name = "plain" },
    { name = "cut", overlap = 0.3, ratio = 0.8 },
    { name = "bent", b = { corruption = [["bend", 2.0]], turn_deg = 90.0 } },
]
[[scenarios]]
name = "strangers"
kind = "other-building"
"""


def test_what_a_suite_leaves_open_is_settled_for_every_seed(tmp_path):
    suite = load_suite(written(tmp_path, OPEN))
    sources = suite.sources()[:6]
    scenarios = [source.scenario for source in sources]

    assert [source.source_id for source in sources] == [f"drawn-000{seed}" for seed in range(4, 10)]
    assert [scenario.split for scenario in scenarios] == ["train", "test"] * 3
    assert suite.scenarios[:6] == tuple(scenarios)
    assert suite.sources() == load_suite(tmp_path / "some.toml").sources()
    for read in (
        lambda scenario: scenario.mission.overlap,
        lambda scenario: scenario.a.resolution,
        lambda scenario: scenario.b.resolution / scenario.a.resolution,
    ):
        assert len({read(scenario) for scenario in scenarios}) == 6
    assert {scenario.world.size_m for scenario in scenarios} == {(20.0, 13.0)}
    assert all(0.5 <= scenario.b.resolution / scenario.a.resolution <= 2.0 for scenario in scenarios)
    assert all(source.pair_ids[1] == f"{source.source_id}-n2" for source in sources)


def test_variants_say_only_what_is_different(tmp_path):
    source = load_suite(written(tmp_path, OPEN)).sources()[6]
    plain, cut, bent = source.scenario.variants
    size = source.scenario.a.resolution

    assert source.pair_ids == ("ways-0000-plain-n0", "ways-0000-cut-n0", "ways-0000-bent-n0")
    assert [variant.a.resolution for variant in (plain, cut, bent)] == [size] * 3
    assert [variant.b.resolution / size for variant in (plain, cut, bent)] == pytest.approx([1.2, 0.8, 1.2])
    assert [variant.overlap for variant in (plain, cut, bent)] == [None, 0.3, None]
    assert plain == replace(bent, name="plain", b=replace(bent.b, corruption=(), turn_deg=0.0))
    assert bent.b.corruption == (("bend", 2.0),)


def test_the_other_building_of_an_unrelated_pair_is_drawn_apart(tmp_path):
    text = OPEN.replace('kind = "other-building"', 'kind = "other-building"\nseeds = { count = 30 }')
    scenarios = load_suite(written(tmp_path, text)).scenarios[7:]

    assert {scenario.other.rooms for scenario in scenarios} == {6, 7, 8, 9}
    assert any(scenario.other.rooms != scenario.world.rooms for scenario in scenarios)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("to = 0.9", "to = 0.2", "scenarios[0].mission.overlap: from must be less than to, got 0.3 and 0.2"),
        ("to = 0.9", "to = 1.2", "scenarios[0].mission: overlap must be 0.1 to 1.0, got 1.2"),
        ("to = 9", "to = 13", "scenarios[0].world: rooms must be 6 to 12, got 13"),
        ("[0, 1] }, 2]", "[0, 2] }, 2]", "scenarios[0]: noise must list different levels"),
        ("[0, 1] }, 2]", "[0, 1], some = 1 }, 2]", "scenarios[0].noise[0]: unknown key 'some' with any_of"),
        ('["train", "test"]', '["train", "dev"]', "scenarios[0].split: must be one of 'train', 'test', got 'dev'"),
        ("to = 2.0, log", "to = 20.0, log", "scenarios[0].ratio: must be 0.1 to 10, got 20.0"),
        ("ratio = 1.2", 'ratio = "1.2"', "scenarios[1].ratio: must be a number, got '1.2'"),
        ("ratio = 1.2", "ratio = 1.2\nb.resolution = 0.1", "scenarios[1].b.resolution: excludes ratio, which sets it"),
        ('"cut", overlap = 0.3', '"cut", overlap = 0.05', "scenarios[1].variants[1]: overlap must be 0.1 to 1.0"),
        ("ratio = 0.8", "noise = [1]", "scenarios[1].variants[1]: unknown key 'noise'"),
        ("ratio = 0.8", "ratio = 0.0", "scenarios[1].variants[1].ratio: must be 0.1 to 10, got 0.0"),
        ('name = "cut"', 'name = "bent"', "scenarios[1]: variants: two have the same name"),
        ('"bend", 2.0', '"bent", 2.0', "scenarios[1].variants[2].b: no corruption 'bent'"),
        ("[base]", "base = 3\n[more]", "base: must be a table"),
        ('"other-building"', '"other"', "scenarios[2].kind: must be one of 'related', 'other-building', "),
        ('"other-building"', '"no-shared-room"', "scenarios[2]: mission.overlap: maps with no shared room have none"),
        ('"other-building"', '"blank-halls"', "scenarios[2]: world.family: must be \"hall\" with kind \"blank-halls\""),
        (
            '"other-building"',
            '"other-floor"\nother = { rooms = 6 }',
            "scenarios[2]: other: kind \"other-floor\" has one building",
        ),
        (
            '"other-building"',
            '"other-storey"\nworld.family = "two-wing"',
            "scenarios[2]: world.family: a building of family two-wing has one storey only",
        ),
        (
            '"other-building"',
            '"other-building"\nother = { family = "hall" }',
            "scenarios[2]: other: must be of the same family, office, got hall",
        ),
        (
            '"other-building"',
            '"related"\nother = { rooms = 6 }',
            "scenarios[2]: other: is for pairs of two buildings",
        ),
    ],
)  # fmt: skip
def test_an_impossible_wish_is_refused_with_its_path(tmp_path, old, new, complaint):
    assert old in OPEN
    with pytest.raises(ScenarioError) as refused:
        load_suite(written(tmp_path, OPEN.replace(old, new, 1)))

    assert str(refused.value).startswith(f"some.toml: {complaint}")


def test_what_only_some_seeds_exclude_is_refused_before_anything_runs(tmp_path):
    text = OPEN.replace("size_m = [20.0, 13.0]", "size_m = [{ from = 14.0, to = 24.0 }, 13.0]").replace(
        "to = 9", "to = 12"
    )
    suite = load_suite(written(tmp_path, text.replace("count = 6", "count = 60")))

    with pytest.raises(ScenarioError, match=r"^some\.toml: scenarios\[0\]\.world: size_m: \d+ rooms beside a corridor"):
        suite.sources()


@pytest.mark.sim
def test_variants_of_one_mission_share_what_they_do_not_change_and_one_that_fails_costs_no_other(tmp_path):
    blotted = 'overlap = 0.3, ratio = 0.8, b = { corruption = [["salt", 1.0]] }'  # no free cell, no overlap
    text = OPEN.replace("overlap = 0.3, ratio = 0.8", blotted)
    source = load_suite(written(tmp_path, text)).sources()[6]
    made = {}
    with pytest.raises(SimulationError, match=r"^ways-0000-cut-n0: the finished maps have .*, wanted was 0\.30$"):
        made.update((pair.info["variant"], pair) for pair in source.pairs())

    assert set(made) == {"plain", "bent"}
