import json

import pytest

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.bench.run import read_rows
from scenarios.cli.main import app
from scenarios.studies.ablation import ABLATIONS
from scenarios.studies.accuracy import regressions
from scenarios.studies.default_method import StudyPlan, write_results
from scenarios.studies.default_method_page import (
    ablation_table,
    brier_line,
    missed_table,
    reliability_table,
    results_table,
    risk_table,
)
from tests.scenarios.dataset.test_reader import ROW, UNRELATED, write
from tests.scenarios.known_answers import Source

SOURCES = {"made": [Source(source_id="m0"), Source(source_id="m1", fails=True)]}


def row(outcome="right-accepted", *, confidence=0.9, e_px=1.0, suite="real_maps", variant="sensor", **changes):
    stratum = changes.get("stratum", "required")
    return {
        "suite": suite,
        "pair_id": "p0",
        "place": "p",
        "stratum": stratum,
        "overlap": None,
        "outcome": outcome,
        "verdict": "accepted",
        "confidence": confidence,
        "grades": ["right" if outcome in ("right-accepted", "ambiguous-with-truth") else "off"],
        "errors": None if e_px is None else {"e_px": e_px},
        "seconds": {"wall": 9.0, "cpu": 0.125},
        "reason": "as made up",
        "info": {"variant": variant},
        **changes,
    }


def cells(table, start):
    (line,) = (line for line in table.splitlines() if line.startswith(f"| {start} |"))
    return [cell.strip() for cell in line.strip("|").split("|")]


@pytest.mark.slow
def test_one_call_runs_every_row_and_writes_the_page_and_a_baseline_it_meets(tmp_path):
    seen = []

    write_results(StudyPlan(SOURCES, [Source()]), tmp_path / "out", on_rows=seen.extend)

    rows = read_rows(tmp_path / "out/run/made")
    page = (tmp_path / "out/README.md").read_text()
    assert len(rows) == 4
    assert len(seen) == len(rows) + 2 * len(ABLATIONS)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"README.md", "baseline.json", "run"}
    assert regressions(rows, json.loads((tmp_path / "out/baseline.json").read_text())) == []
    assert cells(page, "made, pair not made")[1] == "4"  # these pairs say neither variant nor noise
    assert "made m1-unrelated" in page  # the one that could not be made
    assert str(tmp_path) not in page


def test_earlier_results_are_refused_and_replaced_when_forced(tmp_path):
    plan = StudyPlan({"made": [Source()]}, [])
    write_results(plan, tmp_path)

    with pytest.raises(InputError, match="--force"):
        write_results(plan, tmp_path)
    write_results(plan, tmp_path, force=True)


def test_the_command_names_the_data_set_that_is_missing_and_writes_nothing(tmp_path, capsys):
    status = console.run(app, "rectbench", ["results", str(tmp_path), "-o", str(tmp_path / "out")])

    assert status == 2
    assert "real_maps: not a data set" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_plan_holds_every_pair_of_the_real_maps_and_three_rescales_of_each_unrelated_one(tmp_path):
    related = [{**ROW, "pair_id": f"r{i}", "variant": "sensor-hard"} for i in range(2)]
    write(tmp_path / "real_maps", [*related, {**UNRELATED, "pair_id": "q", "variant": "negative"}])
    write(tmp_path / "real_lasers", [{**ROW, "variant": "laser"}])

    plan = StudyPlan.from_folder(tmp_path)

    ids = {name: [pair_id for source in sources for pair_id in source.pair_ids] for name, sources in plan.tasks.items()}
    assert ids["real_maps"] == ["r0", "r1"]
    assert ids["negatives"] == ["q-turn1", "q-turn2", "q-turn3"]
    assert ids["real_lasers"] == ["p"]
    assert [source.source_id for source in plan.ablated] == ["r0", "r1", "p"]
    assert (len(ids["smoke"]), len(ids["headline"])) == (10, 100)
    assert plan.row_count == 2 + 3 + 1 + 110 + 3 * len(ABLATIONS)


def test_the_table_counts_every_outcome_and_sums_up_what_an_aim_is_set_for():
    outcomes = ("right-accepted", "wrong-accepted", "ambiguous-with-truth", "rejected", "timeout")
    groups = {
        "real_maps sensor": [row(outcome, e_px=e) for e, outcome in enumerate(outcomes)],
        "real_maps sensor-hard": [row(variant="sensor-hard")],
        "something new": [row(variant="new")] * 7,
    }

    table = results_table(groups)

    shown = cells(table, "hand-held, as they are")
    assert shown[1:3] == ["5", "2"]
    assert shown[3].startswith("1 of 5 (20 %")
    assert shown[4:10] == ["1", "1", "1", "1", "2.00", "0.12"]
    assert cells(table, "**both**")[1] == "6"
    assert cells(table, "something new")[1] == "7"


def test_of_unrelated_pairs_the_table_gives_false_merges_as_a_rate():
    table = results_table(
        {"real_maps negative": [row("rejected", stratum="unrelated"), row("wrong-accepted", stratum="unrelated")]}
    )

    shown = cells(table, "**other places**, turned and rescaled")
    assert shown[2:4] == ["-", "-"]
    assert shown[4].startswith("1 of 2")


def test_what_is_missed_is_listed_by_id_with_its_reason():
    rows = [
        row(),
        row("rejected", pair_id="lost", reason="a | b"),
        row("ambiguous-without-truth", pair_id="refused", stratum="unrelated"),
        row("wrong-accepted", pair_id="false", stratum="unrelated"),
    ]

    table = missed_table(rows)

    assert "lost" in table
    assert "a \\| b" in table
    assert "false" in table
    assert "refused" not in table
    assert missed_table(rows[:1]) == "None.\n"


def test_the_confidence_is_compared_with_what_was_right():
    rows = [row(confidence=1.0), row("wrong-accepted", confidence=0.5), row("timeout", verdict=None, confidence=None)]

    assert "2 answers" in brier_line(rows)
    assert "Brier score 0.1250; always saying their share would score 0.2500" in brier_line(rows)
    assert cells(reliability_table(rows), "0.99 to 1")[1:] == ["1", "1.000", "1.000"]
    assert cells(reliability_table(rows), "0.35 to 0.65")[1:] == ["1", "0.500", "0.000"]


def test_risk_counts_what_is_wrong_among_the_most_confident():
    rows = [row(confidence=0.9), row("wrong-accepted", confidence=0.2), row(confidence=0.8), row(confidence=0.7)]
    rows.append(row("wrong-accepted", confidence=0.1, stratum="unrelated"))

    table = risk_table(rows)

    assert cells(table, "75 %")[1:] == ["1 of 4", "0 of 3"]
    assert cells(table, "100 %")[1:] == ["2 of 5", "1 of 4"]


def test_an_ablation_shows_what_it_costs():
    lasers = [row(e_px=0.25, suite="real_lasers", variant="laser"), row("wrong-accepted", e_px=3, suite="real_lasers")]
    rows = [row(), row("ambiguous-with-truth"), *lasers, row("rejected", suite="real_lasers", stratum="unrelated")]

    assert cells(ablation_table({"forms": rows}), "forms")[1:] == ["1 of 2", "1 of 2", "3", "1", "1.00", "1.62", "0.12"]
