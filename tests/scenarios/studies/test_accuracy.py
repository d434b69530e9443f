"""The default method against the committed baseline, and the rules of that comparison."""

import copy
import functools
import json
import os
from pathlib import Path

import pytest

from rectmerge.methods import DEFAULT_METHOD, make_method
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import score_answer
from scenarios.bench.task_ids import task_ids
from scenarios.bench.tasks import RunSettings, Task, run_task
from scenarios.studies.accuracy import baseline_of, count, group_of, grouped, real_tasks, regressions, simulated_tasks
from scenarios.suites.suite import load_suite

BASELINE = Path(__file__).parents[3] / "results/robust/baseline.json"
MAPS = os.environ.get("RECTMERGE_REAL_MAPS")
needs_maps = pytest.mark.skipif(
    not MAPS, reason="RECTMERGE_REAL_MAPS does not name the folder that holds real_maps and real_lasers"
)


def rows_of(name, sources):
    contenders = [Contender(label=DEFAULT_METHOD, method=make_method(DEFAULT_METHOD))]
    settings = RunSettings(contenders=contenders, suite=name)
    tasks = [Task(source=source, due=task_ids(source, contenders, seed=0), settings=settings) for source in sources]
    return [row for task in tasks for row in run_task(task).rows]


@pytest.fixture(scope="module")
def unbent():
    """Leave out the bending of accepted maps, which takes most of the time: no figure of the baseline is of it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenarios.bench.tasks.score_answer_and_bend", score_answer)
        yield


def assert_no_regression(rows):
    assert rows
    assert regressions(rows, json.loads(BASELINE.read_text())) == []


@functools.cache
def real(name):
    return rows_of(name, real_tasks(MAPS)[name])


@pytest.mark.real
@needs_maps
@pytest.mark.usefixtures("unbent")
@pytest.mark.parametrize("variant", ["sensor", "sensor-hard", "layout", "layout-hard"])
def test_hand_held_maps_are_merged_as_well_as_before(variant):
    assert_no_regression([row for row in real("real_maps") if row["info"]["variant"] == variant])


@pytest.mark.real
@needs_maps
@pytest.mark.usefixtures("unbent")
def test_laser_maps_are_merged_as_well_as_before():
    assert_no_regression(real("real_lasers"))


@pytest.mark.real
@pytest.mark.slow
@needs_maps
def test_maps_of_other_places_are_refused():
    rows = rows_of("negatives", real_tasks(MAPS)["negatives"][::10])  # every turn; `rectbench results` asks all 216

    assert len(rows) == 22
    assert count(rows)["wrong-accepted"] == 0


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.usefixtures("unbent")
def test_simulated_maps_are_merged_as_well_as_before():
    assert_no_regression(rows_of("smoke", simulated_tasks(["smoke"])["smoke"]))


@pytest.mark.parametrize("suite", ["smoke", "headline"])
def test_the_scale_is_free_in_every_simulated_row(suite):
    assert all(scenario.a.hide_resolution or scenario.b.hide_resolution for scenario in load_suite(suite).scenarios)


def row(outcome="right-accepted", e_px=1.0, stratum="required", suite="real_maps", variant="sensor"):
    return {
        "suite": suite,
        "stratum": stratum,
        "outcome": outcome,
        "grades": [] if e_px is None else ["right" if outcome == "right-accepted" else "off"],
        "errors": None if e_px is None else {"e_px": e_px},
        "info": {"variant": variant},
    }


TEN = [row(e_px=e) for e in range(1, 11)]


def test_the_same_rows_are_no_regression():
    assert regressions(TEN, baseline_of(TEN)) == []


def test_one_pair_may_be_lost_but_not_two():
    lost = row("ambiguous-with-truth")

    assert regressions([*TEN[:9], lost], baseline_of(TEN)) == []
    assert regressions([*TEN[:8], lost, lost], baseline_of(TEN)) == ["real_maps sensor: 8 right and accepted, was 10"]


def test_one_wrong_accept_is_a_regression_whatever_the_baseline_had():
    worse = [*TEN[:9], row("wrong-accepted")]

    assert regressions(worse, baseline_of(worse)) == ["real_maps sensor: 1 wrong and accepted"]


@pytest.mark.parametrize(("growth", "n"), [(1.19, 0), (1.21, 1)])
def test_the_median_error_may_grow_by_a_fifth(growth, n):
    grown = [row(e_px=growth * before["errors"]["e_px"]) for before in TEN]

    assert len(regressions(grown, baseline_of(TEN))) == n


def test_answers_without_a_candidate_are_not_left_out_of_the_median():
    lost = [row("rejected", e_px=None)] * 6

    assert any("median error None" in line for line in regressions([*TEN[:4], *lost], baseline_of(TEN)))


def test_a_group_that_lost_pairs_or_is_new_is_a_regression():
    baseline = baseline_of(TEN)
    without = copy.deepcopy(baseline)
    without["groups"].clear()

    assert regressions(TEN[:9], baseline) == ["real_maps sensor: 9 pairs, the baseline has 10"]
    assert regressions(TEN, without) == ["real_maps sensor: 10 pairs, the baseline has none"]


def test_rows_are_grouped_by_data_set_variant_and_stratum_and_simulated_ones_by_noise():
    assert group_of(row()) == "real_maps sensor"
    assert group_of(row(stratum="optional", suite="real_lasers", variant="laser")) == "real_lasers laser, optional"
    assert group_of(row(stratum="unrelated", variant="negative")) == "real_maps negative"
    assert group_of({**row(), "suite": "smoke", "info": {"noise": 1}}) == "smoke, noise 1"
    assert group_of({**row("error", None), "suite": "smoke", "info": None}) == "smoke, pair not made"
    assert list(grouped([row(), row(variant="layout"), row()])) == ["real_maps sensor", "real_maps layout"]


def test_an_unrelated_pair_is_never_right():
    unrelated = {**row(), "stratum": "unrelated", "outcome": "wrong-accepted"}

    assert (count([unrelated])["right"], count([row()])["right"]) == (0, 1)
