"""Pairs made and answered: whatever happens becomes a row."""

import pytest

from rectmerge.grid import OccupancyGrid
from scenarios.bench.task_ids import task_ids
from scenarios.bench.tasks import RunSettings, Task, failed_task, run_task
from scenarios.execution.attempt import Attempt
from scenarios.execution.limits import Limits
from scenarios.scoring.summary import summarise
from tests.scenarios.known_answers import Failing, Lost, Source, contender, grid, outcomes, pair


def rows_from(source, contenders, **settings):
    due = task_ids(source, contenders, seed=0)
    shared = RunSettings(suite="made", contenders=contenders, **settings)
    return run_task(Task(source=source, due=due, settings=shared)).rows


def test_a_pair_that_cannot_be_made_is_an_error_of_every_contender():
    rows = rows_from(Source(fails=True), [contender(), contender(label="two")])

    assert outcomes(rows) == [
        ("m0-related", "one", "right-accepted"),
        ("m0-related", "two", "right-accepted"),
        ("m0-unrelated", "one", "error"),
        ("m0-unrelated", "two", "error"),
    ]
    assert "the robot fell over" in rows[-1]["reason"]
    assert rows[0].keys() == rows[-1].keys()


def test_a_pair_that_cannot_be_scored_is_an_error():
    class Unknown(Source):
        def pairs(self):
            yield pair("m0-related", a=OccupancyGrid(0 * grid().occupancy - 1))

    rows = rows_from(Unknown(), [contender()])

    assert [row["outcome"] for row in rows] == ["error", "error"]
    assert "no known cell" in rows[0]["reason"]
    assert "ended without it" in rows[1]["reason"]


def test_a_pair_that_cannot_be_made_counts_where_it_was_meant_to():
    due = task_ids(Source(), [contender()], seed=0)
    task = Task(source=Source(fails=True), due=due, settings=RunSettings(suite="made", contenders=[contender()]))
    lost = failed_task(task, Attempt(failure="error", reason="the worker died"))

    for rows in (run_task(task).rows, lost.rows):
        assert [(row["stratum"], row["related"]) for row in rows] == [("required", True), ("unrelated", False)]
        assert summarise(rows)["one"]["unrelated"]["wrong_accepted"]["n"] == 1


def test_only_the_tasks_that_are_asked_for_are_done():
    contenders = [contender(), contender(label="two")]
    settings = RunSettings(suite="made", contenders=contenders)

    rows = run_task(Task(source=Source(), due={("m0-unrelated", "two"): "5"}, settings=settings)).rows

    assert [(row["task_id"], *key) for row, key in zip(rows, outcomes(rows), strict=True)] == [
        ("5", "m0-unrelated", "two", "wrong-accepted")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "outcome", "reason"),
    [
        (Failing(how="hang"), "timeout", "no answer within 0.3 s"),
        (Failing(how="killed"), "out-of-memory", "was killed, most likely for want of memory, 3 times"),
        (Failing(how="exit"), "error", "died with status 7, 3 times"),
        (Failing(how="greedy"), "out-of-memory", "took more than 1000 MB"),
    ],
)
def test_a_method_that_takes_its_process_along_costs_its_own_rows(method, outcome, reason):
    contenders = [contender(method), contender(label="two")]

    limits = Limits(timeout_s=0.3 if outcome == "timeout" else 30, memory_mb=1000)
    rows = rows_from(Source(), contenders, limits=limits)

    assert [row["outcome"] for row in rows] == [outcome, "right-accepted", outcome, "wrong-accepted"]
    assert reason in rows[0]["reason"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "outcome", "reason"),
    [("hang", "timeout", "no pairs within 0.3 s"), ("exit", "error", "that makes pairs died with status 7, 3 times")],
)
def test_a_mission_that_hangs_or_takes_its_process_along_costs_its_own_rows(how, outcome, reason):
    rows = rows_from(Lost(how=how), [contender()], making=Limits(timeout_s=0.3 if how == "hang" else 30))

    assert [row["outcome"] for row in rows] == [outcome, outcome]
    assert reason in rows[0]["reason"]
