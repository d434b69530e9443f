from dataclasses import replace

import pytest

from scenarios.leaderboard.page import page
from scenarios.report.difficulty import Box, box_of, heat_maps, leaders, leaders_line, leaders_map
from scenarios.report.page import html
from scenarios.report.reading import Runs, TrackResults
from scenarios.scoring.row import empty_row
from scenarios.suites.suite import load_suite
from sim.floorplans import Apartment


def answers(method, variant, outcomes, *, noise=0, e=0.004, cpu=0.5):
    """One row per outcome: r right, w wrong, n not accepted and no candidate."""
    names = {"r": "right-accepted", "w": "wrong-accepted", "n": "rejected"}
    rows = []
    for seed, letter in enumerate(outcomes):
        row = empty_row(
            pair_id=f"grid-{seed}-{variant}-n{noise}",
            suite="grid",
            place=f"grid-{seed}",
            method=method,
            related=True,
            stratum="required",
            outcome=names[letter],
            reason="made",
        )
        errors = None if letter == "n" else {"e_px": 1.0, "e_over_l": e, "rotation_deg": 0.1, "scale_pct": 0.1}
        info = {"variant": variant, "noise": noise}
        told = {"verdict": "accepted", "confidence": 0.9, "grades": ["right" if letter == "r" else "off"]}
        rows.append(row | told | {"info": info, "errors": errors, "seconds": {"cpu": cpu, "wall": cpu}})
    return rows


ROWS = [
    *answers("strong", "rigid-0.1", "rrn"),
    *answers("strong", "slam-bent-1.0", "nnn", noise=2),
    *answers("weak", "rigid-0.1", "rwr"),
    *answers("weak", "slam-bent-1.0", "nnw", noise=2, e=0.5),
]
GRID = TrackResults("grid", "unknown scale", ROWS)


def cells(table):
    return {
        (name, column): cell.text
        for name, line in table.lines
        for column, cell in zip(table.columns, line, strict=True)
    }


def test_the_suite_has_54_boxes_of_20_pairs_with_two_of_each_family():
    sources = load_suite("grid").sources()
    boxes = [
        box_of({"variant": variant.name, "noise": noise})
        for source in sources
        for variant in source.scenario.variants
        for noise in source.scenario.noise
    ]
    found = [box for box in boxes if box]

    assert len(found) == 1080
    assert {found.count(box) for box in set(found)} == {20}
    assert {box.overlap for box in found} == {0.1, 0.26, 0.42, 0.58, 0.74, 0.9}
    assert {box.line for box in found} == {
        f"{differs}, noise {noise}" for differs in ("rigid", "slam", "slam and bent") for noise in (0, 1, 2)
    }
    families = [(source.scenario.mission.overlap, source.scenario.world.family) for source in sources]
    assert {families.count(family) for family in families} == {2}
    assert all(str(s.scenario.mission.overlap) in v.name for s in sources for v in s.scenario.variants)


@pytest.mark.sim
def test_pairs_of_the_suite_know_their_box():
    source = load_suite("grid").missions()[-1]
    small = replace(
        source.scenario,
        variants=source.scenario.variants[-1:],
        noise=(1,),
        world=Apartment(size_m=(11.0, 9.0), rooms=3),
        mission=replace(source.scenario.mission, max_seconds=40.0),
    )

    (pair,) = replace(source, scenario=small).mission_pairs().pairs

    assert box_of(pair.info) == Box(2, "1", 0.9)
    assert pair.residual_px > 0


def test_a_heat_map_has_counts_errors_and_times():
    (label, (success, error, time)), _ = heat_maps(GRID)

    assert label == "strong"
    assert cells(success) == {
        ("rigid, noise 0", "0.1"): "2 of 3",
        ("rigid, noise 0", "1"): "-",
        ("slam and bent, noise 2", "0.1"): "-",
        ("slam and bent, noise 2", "1"): "0 of 3",
    }
    assert cells(error)["rigid, noise 0", "0.1"] == "0.40"
    assert cells(error)["slam and bent, noise 2", "1"] == "none"
    assert cells(time)["rigid, noise 0", "0.1"] == "0.50"


def test_the_better_is_darker():
    (_, (success, *_)), _ = heat_maps(GRID)
    shades = [line[column].style for column, (_, line) in enumerate(success.lines)]

    assert shades[1] == "background:#f7f7f7;color:#1c1c1c"
    assert shades[0] != shades[1]


def test_the_first_has_most_right_and_of_equals_fewest_wrong():
    first = leaders(GRID)

    assert first[Box(0, "0", 0.1)].labels == ("strong",)
    assert str(first[Box(2, "2", 1.0)]) == "nobody, 0 of 3"
    assert leaders_line(first) == "strong is first in 1 of 2 boxes, in 1 alone; nobody is right in 1."


def test_equals_share_the_first_place():
    rows = [*answers("one", "slam-0.46", "rr"), *answers("two", "slam-0.46", "rr")]
    first = leaders(TrackResults("grid", "unknown scale", rows))

    assert cells(leaders_map(first)) == {("slam, noise 0", "0.46"): "one + two 2 of 2"}
    assert leaders_line(first).startswith("one is first in 1 of 1 boxes, in 0 alone; two is first")


OTHERS = ["drift-0.2", "slam", "slam-3", "rigid-", None]


@pytest.mark.parametrize("variant", OTHERS)
def test_rows_of_other_suites_are_no_grid(variant):
    other = TrackResults("other", "unknown scale", answers("strong", variant, "r"))

    assert heat_maps(other) == []
    assert leaders(other) == {}


@pytest.mark.parametrize("variant", OTHERS)
def test_a_pair_of_no_box_is_left_out_of_the_grid(variant):
    rows = [*answers("strong", variant, "r"), *ROWS]

    assert heat_maps(TrackResults("grid", "unknown scale", rows)) == heat_maps(GRID)


def test_a_failure_that_knows_nothing_of_its_pair_counts_in_the_box_of_the_pairs_other_rows():
    failed = [row | {"method": "lost", "outcome": "error", "info": None} for row in answers("", "rigid-0.1", "rr")]
    grid = TrackResults("grid", "unknown scale", [*failed, *ROWS])

    label, (success, *_) = heat_maps(grid)[0]

    assert label == "lost"
    assert cells(success) == {("rigid, noise 0", "0.1"): "0 of 2"}
    assert leaders(grid) == leaders(GRID)


def test_the_report_and_the_leaderboard_say_who_is_first():
    runs = Runs([GRID], [], {})

    shown, written = html(runs), page(runs)

    assert "<h3>Where does it fail?</h3>" in shown
    assert shown.count('<table class="heat">') == 1 + 2 * 3
    assert "2 of 3, 1 wrong" in shown
    assert "| rigid, noise 0 | strong 2 of 3 | - |" in written
    assert "strong is first in 1 of 2 boxes" in written
