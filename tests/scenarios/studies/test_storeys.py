import json

import pytest

from rectmerge.errors import InputError
from scenarios.studies import storeys


def row(outcome, *, stratum="required", family="office", seed=0):
    return {
        "suite": "storeys",
        "pair_id": f"{family}-{seed}-n1",
        "place": f"{family}-{seed}",
        "method": "robust",
        "reason": "",
        "stratum": stratum,
        "overlap": None if stratum == "unrelated" else 0.8,
        "outcome": outcome,
        "confidence": 0.9,
        "info": {"family": family, "noise": 1, "suite_version": 2},
    }


ROWS = [
    row("rejected", stratum="unrelated"),
    row("wrong-accepted", stratum="unrelated", family="loop"),
    row("right-accepted"),
    row("ambiguous-with-truth", seed=1),
    row("right-accepted", family="loop"),
]


def test_joins_of_two_storeys_and_of_one_are_counted_by_family():
    alike, changed = ROWS[:2], ROWS[2:]

    assert "| robust | all | 1 of 2 (50 %," in storeys.storeys_table(alike)
    assert "| robust | loop | 1 of 1" in storeys.storeys_table(alike)
    assert "| robust | all | 2 of 3 (67 %," in storeys.changes_table(changed)
    assert "| robust | office | 1 of 2 (50 %, 0-100) | 0 | 1 | 0 | 0 |" in storeys.changes_table(changed)


def test_the_page_lists_every_false_join_and_names_the_commit(tmp_path):
    (tmp_path / "results.jsonl").write_text("".join(json.dumps(line) + "\n" for line in ROWS))
    (tmp_path / "summary.json").write_text("{}")
    machine = {"commit": "abc", "processor": "Z80", "cores": 1, "system": "s", "python": "3", "command": "c"}
    (tmp_path / "machine.json").write_text(json.dumps(machine))

    storeys.write_page(tmp_path, tmp_path / "page.md")

    page = (tmp_path / "page.md").read_text()
    assert "Run by commit abc; Z80, 1 cores." in page
    assert "| storeys loop-0-n1 | loop |" in page


def test_a_run_of_another_suite_is_refused(tmp_path):
    (tmp_path / "results.jsonl").write_text(json.dumps({**ROWS[0], "suite": "smoke"}) + "\n")
    (tmp_path / "summary.json").write_text("{}")

    with pytest.raises(InputError, match="holds no rows of storeys; make it with: rectbench run storeys"):
        storeys.write_page(tmp_path, tmp_path / "page.md")


@pytest.mark.parametrize(
    ("content", "message"),
    [(None, "cannot be read"), ("{", "cannot be read"), ("[]", "cannot be read"), ("{}", "there is no 'processor'")],
)
def test_a_run_of_an_unknown_machine_is_refused_with_the_file(tmp_path, content, message):
    (tmp_path / "results.jsonl").write_text(json.dumps(ROWS[0]) + "\n")
    (tmp_path / "summary.json").write_text("{}")
    if content is not None:
        (tmp_path / "machine.json").write_text(content)

    with pytest.raises(InputError, match=f"machine.json: .*{message}"):
        storeys.write_page(tmp_path, tmp_path / "page.md")
