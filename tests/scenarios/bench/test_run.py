import json
import resource
import tomllib

import pytest

from rectmerge.errors import InputError
from scenarios.bench.contenders import make_contenders
from scenarios.bench.resume import open_results
from scenarios.bench.run import read_rows
from scenarios.dataset.reader import open_dataset
from scenarios.execution.limits import Limits
from scenarios.suites.suite import ContenderSpec
from tests.marking import some_slow
from tests.scenarios.known_answers import Fixed, Source, contender, run_pairs


def timeless(folder):
    rows = [{**row, "seconds": None, "peak_mb": None} for row in read_rows(folder)]
    return sorted(rows, key=lambda row: row["task_id"])


@pytest.mark.slow
def test_pairs_are_kept_in_a_data_set_beside_the_rows(tmp_path):
    sources = [Source(), Source(source_id="m1", fails=True)]
    run_pairs(sources, [contender()], tmp_path, suite="made", card={"title": "Made", "description": "for tests"})

    again = run_pairs(open_dataset(tmp_path / "dataset"), [contender()], tmp_path / "again", suite="made")
    first, second = (
        {row["pair_id"]: row["outcome"] for row in read_rows(folder)} for folder in (tmp_path, tmp_path / "again")
    )
    assert again["rows"] == 3
    assert first == second | {"m1-unrelated": "error"}


@pytest.mark.slow
def test_kept_pairs_are_whole_after_an_interruption(tmp_path):
    def interrupt(rows):
        raise KeyboardInterrupt

    def keep(out, **options):
        card = {"title": "Made", "description": "for tests"}
        run_pairs([Source(), Source(source_id="m1")], [contender()], out, suite="made", card=card, **options)

    keep(tmp_path / "whole")
    with pytest.raises(KeyboardInterrupt):
        keep(tmp_path / "cut", on_rows=interrupt)
    keep(tmp_path / "cut")

    whole, cut = (
        {path.name: path.read_bytes() for path in (tmp_path / name / "dataset").rglob("*.[pj]*")}
        for name in ("whole", "cut")
    )
    assert whole == cut
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")


def test_a_run_writes_its_folder(tmp_path):
    seen = []

    summary = run_pairs(
        [Source(), Source(source_id="m1")],
        [contender(), contender(Fixed(verdict="rejected"), "shy")],
        tmp_path / "run",
        suite="made",
        seed=5,
        about={"scenarios": [{"size": (3, 4), "canvas": None}]},
        command="rectbench run made",
        on_rows=seen.extend,
    )

    rows = read_rows(tmp_path / "run")
    settings = tomllib.loads((tmp_path / "run/run.toml").read_text())
    machine = json.loads((tmp_path / "run/machine.json").read_text())
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        *("run.toml", "machine.json", "results.jsonl", "summary.json")
    }
    assert len(rows) == len(seen) == summary["rows"] == 8
    assert json.loads((tmp_path / "run/summary.json").read_text()) == summary
    assert summary["methods"]["one"]["required"]["right_accepted"]["k"] == 2
    assert summary["methods"]["one"]["unrelated"]["wrong_accepted"]["k"] == 2
    assert summary["methods"]["shy"]["unrelated"]["outcomes"] == {"rejected": 2}
    assert settings["seed"] == 5
    assert settings["scenarios"] == [{"size": [3, 4]}]
    assert settings["methods"][1] == {
        "label": "shy",
        "method": "fixed",
        "knows_scale": False,
        "set": {"verdict": "rejected", "tx": 4.0, "confidence": 0.75},
    }
    assert machine["command"] == "rectbench run made"
    assert rows[0]["trace"]["ratio"] is None  # strict JSON has no infinity


def test_same_seed_same_rows_and_another_seed_reaches_the_method(tmp_path):
    def draws(name, seed):
        run_pairs([Source()], [contender()], tmp_path / name, suite="made", seed=seed)
        return [row["trace"]["draw"] for row in read_rows(tmp_path / name)]

    assert draws("a", 1) == draws("b", 1) != draws("c", 2)


def test_a_run_goes_on_where_it_was_interrupted(tmp_path):
    def interrupt(rows):
        raise KeyboardInterrupt

    sources, started = [Source(), Source(source_id="m1")], []
    run_pairs(sources, [contender()], tmp_path / "whole", suite="made")
    with pytest.raises(KeyboardInterrupt):
        run_pairs(sources, [contender()], tmp_path / "cut", suite="made", on_rows=interrupt)
    with pytest.raises(InputError, match="no finished run"):
        read_rows(tmp_path / "cut")
    run_pairs(sources, [contender()], tmp_path / "cut", suite="made", on_start=started.append)

    assert started == [2]
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")


@pytest.mark.parametrize("cut", some_slow([1, 40, 900], 40))
def test_a_torn_line_and_lost_lines_are_done_again(tmp_path, cut):
    sources = [Source(), Source(source_id="m1")]
    run_pairs(sources, [contender(), contender(label="two")], tmp_path, suite="made")
    rows, file = timeless(tmp_path), tmp_path / "results.jsonl"
    file.write_bytes(file.read_bytes()[:-cut])

    run_pairs(sources, [contender(), contender(label="two")], tmp_path, suite="made")

    assert timeless(tmp_path) == rows


def test_a_damaged_line_is_named(tmp_path):
    run_pairs([Source()], [contender()], tmp_path, suite="made")
    file = tmp_path / "results.jsonl"
    file.write_bytes(b"{torn\n" + file.read_bytes())

    with pytest.raises(InputError, match=r"results.jsonl:1: not JSON"):
        run_pairs([Source()], [contender()], tmp_path, suite="made")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "differs"),
    [
        ({"suite": "other"}, "another suite"),
        ({"seed": 3}, "another seed"),
        ({"contenders": [contender(Fixed(tx=5.0))]}, "another methods"),
        ({"sources": [Source(), Source(source_id="m1")]}, "another pairs"),
        ({"sources": [Source(fails=True)]}, "another content of the pairs"),
    ],
)
def test_a_run_of_something_else_is_refused_and_cleared_only_with_force(tmp_path, change, differs):
    same = {"sources": [Source()], "contenders": [contender()], "suite": "made", "seed": 0, "out": tmp_path}
    run_pairs(**same)
    (tmp_path / "notes.txt").write_text("mine")

    with pytest.raises(InputError, match=f"{differs}.*--force"):
        run_pairs(**{**same, **change})
    assert run_pairs(**same, limits=Limits(timeout_s=9))["rows"] == 2  # limits may differ
    summary = run_pairs(**{**same, **change}, force=True)

    assert summary["rows"] == len(read_rows(tmp_path))
    assert (tmp_path / "notes.txt").exists()


def test_rows_of_an_unknown_run_are_not_added_to(tmp_path):
    run_pairs([Source()], [contender()], tmp_path, suite="made")
    (tmp_path / "run.toml").unlink()

    with pytest.raises(InputError, match="--force"):
        run_pairs([Source()], [contender()], tmp_path, suite="made")


def test_of_two_runs_into_one_folder_the_second_is_refused(tmp_path):
    def again(rows):
        run_pairs([Source()], [contender()], tmp_path, suite="made", force=True)

    with pytest.raises(InputError, match="another process is writing into it"):
        run_pairs([Source()], [contender()], tmp_path, suite="made", on_rows=again)


def test_rows_that_the_disk_has_no_room_for_end_a_run_in_one_line(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        with open_results(tmp_path, 'run_id = "1"', force=False) as results:
            resource.setrlimit(resource.RLIMIT_FSIZE, (10, before[1]))
            with pytest.raises(InputError, match=r"results\.jsonl: cannot be written: File too large"):
                results.add([{"task_id": "1", "why": "longer than ten bytes"}])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_file_of_rows_that_is_not_ours_is_left_as_it_was(tmp_path):
    (tmp_path / "results.jsonl").write_text("of somebody else, without an end")

    with pytest.raises(InputError, match="holds a run of something else"):
        run_pairs([Source()], [contender()], tmp_path, suite="made")
    assert (tmp_path / "results.jsonl").read_text() == "of somebody else, without an end"


def test_labels_differ(tmp_path):
    with pytest.raises(InputError, match="labels must differ"):
        run_pairs([Source()], [contender(), contender()], tmp_path, suite="made")


def test_results_do_not_overwrite_a_file(tmp_path):
    (tmp_path / "file").write_text("mine")

    with pytest.raises(InputError, match="is a file"):
        run_pairs([Source()], [contender()], tmp_path / "file", suite="made")


def test_run_toml_keeps_the_fields_of_groups(tmp_path):
    contenders = make_contenders(["robust"], [], ["robust.rank.spreads_cells=1,2,5", "robust.max_candidates=20"])

    run_pairs([Source()], contenders, tmp_path / "run")

    (method,) = tomllib.loads((tmp_path / "run/run.toml").read_text())["methods"]
    assert method["set"]["max_candidates"] == 20
    assert method["set"]["rank"]["spreads_cells"] == [1.0, 2.0, 5.0]
    again = ContenderSpec(label="again", method="robust", set=method["set"])
    assert make_contenders(["again"], [again])[0].method == contenders[0].method
