import json
import os
import shutil
from pathlib import Path

import pytest

from rectmerge.cli import console
from rectmerge.errors import DatasetError
from scenarios.cli.main import app
from scenarios.dataset.dataset_id import checksum
from scenarios.dataset.generate import generate
from scenarios.dataset.verify import verify
from tests.scenarios.tiny_suite import TinySuite


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "tiny"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda dataset: b"a picture")
        generate(TinySuite(), folder)
    return folder


@pytest.fixture
def made(whole, tmp_path):
    return Path(shutil.copytree(whole, tmp_path / "set"))


def edit(made, split, line, **changes):
    """Change a row, and forget the checksums, which would tell of any change."""
    path = made / split / "metadata.jsonl"
    rows = [json.loads(row) for row in path.read_text().splitlines()]
    rows[line - 1].update(changes)
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    (made / "dataset_info.json").unlink()


def test_what_generate_writes_is_right(made):
    verdict = verify(made)

    assert (verdict.pairs, verdict.faults, verdict.notes) == (10, (), ())
    assert verdict.files == 29


def test_without_its_info_a_data_set_is_checked_but_for_checksums(made):
    (made / "dataset_info.json").unlink()
    verdict = verify(made)

    assert (verdict.pairs, verdict.files, verdict.faults) == (10, 0, ())
    assert "no dataset_info.json" in verdict.notes[0]


FIT = {"pixels": [[1, 0, 7.2], [0, 1, 4]], "control_points": [[7, 4, 0, 0], [17, 4, 10, 0], [7, 14, 0, 10]]}
WRONG = {
    "overlap": ({"overlap": 0.2}, "overlap is 0.2, but under the truth the maps have 1."),
    "fit": (
        {**FIT, "residual_px": 0.2, "b_to_a": None},
        "not the least-squares fit to control_points: up to 0.200 pixels off",
    ),
    "frames": (
        {"b_to_a": {"scale": 1.0, "angle_rad": 0.0, "translation": [0.0, 0.0], "unit": "cells"}},
        "b_to_a does not say what pixels says",
    ),
    "no frames": ({"b_to_a": {"unit": "cells"}}, "b_to_a must have scale"),
    "residual": ({"residual_px": 3.0}, "residual_px is 3.0, but pixels leave"),
    "resolution": ({"resolution_b": 0.06}, "resolution_b is 0.06, 000004_b.yaml says 0.05"),
    "map": ({"map_a_file_name": "maps/none.png"}, "no file 'maps/none.png'"),
    "image": ({"map_b_file_name": "maps/000004_a.png"}, "000004_b.yaml is of the image 000004_b.png"),
    "building": ({"place": "tiny/rooms-0000"}, "place 'tiny/rooms-0000' is in the split train too"),
    "raster": ({"world": "worlds/none.png"}, "worlds/none.yaml: no such file"),
    "id": ({"pair_id": "rooms-0000-same"}, "pair_id 'rooms-0000-same' is used in "),
}


@pytest.mark.parametrize(("changes", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_row_is_told_with_its_file_and_line(made, changes, message):
    edit(made, "test", 2, **changes)

    (fault,) = verify(made).faults
    assert fault.startswith(f"{made}/test/metadata.jsonl:2: ")
    assert message in fault


def test_every_fault_is_told(made):
    edit(made, "test", 1, overlap=0.2)
    with (made / "train/metadata.jsonl").open("a") as rows:
        rows.write("{\n")

    faults = verify(made).faults
    assert [fault.split(": ")[0].rpartition("/")[2] for fault in faults] == ["metadata.jsonl:5", "metadata.jsonl:1"]
    assert "not JSON" in faults[0]


def test_files_that_were_changed_or_lost_are_told(made):
    (made / "test/maps/000004_a.png").unlink()
    with (made / "README.md").open("a") as card:
        card.write("more")
    (made / "train/maps/000000_a.png").write_bytes(b"no image")

    faults = verify(made).faults
    for name, what in (("README.md", "SHA-256"), ("000004_a.png", "is missing"), ("000000_a.png", "not an image")):
        assert any(name in fault and what in fault for fault in faults), faults


def test_a_file_that_cannot_be_read_is_told_and_the_rest_is_checked(made, monkeypatch):
    broken = {made / "train/maps/000000_a.png", made / "README.md"}

    def read(path):
        if path in broken:
            raise OSError(5, "Input/output error")
        return checksum(path)

    monkeypatch.setattr("scenarios.dataset.verify.checksum", read)
    (made / "test/maps/000004_a.png").unlink()

    faults = verify(made).faults
    assert faults[:3] == (
        *(f"{path}: cannot be read: Input/output error" for path in sorted(broken)),
        f"{made}/test/maps/000004_a.png: is missing",
    )


SUBMISSIONS_OWN = {
    "--data-set": ["--data-set", "sets/other"],
    "-o": ["-o", "new.json"],
    "--every": ["--every", "2"],
    "--method-command": ["--method-command", "mine=prog {a} {b}"],
    "--workers": ["--workers", "2"],
    "--force": ["--force"],
}


@pytest.mark.parametrize(("option", "words"), SUBMISSIONS_OWN.items(), ids=SUBMISSIONS_OWN)
def test_an_option_of_submissions_is_refused_for_a_data_set(made, tmp_path, capsys, option, words):
    for target, found in ((made, "is a folder"), (tmp_path / "none.json", "is no file")):
        assert console.run(app, "rectbench", ["verify", str(target), *words, "-q"]) == console.BAD_INPUT
        told = capsys.readouterr().err
        assert f"{target}: {found}; {option} goes with the file of a submission: leave it out" in told
        assert told.count("\n") == 1


def test_files_that_nobody_lists_and_another_id_are_told(made):
    (made / "test/maps/more.png").write_bytes(b"more")
    assert verify(made).faults == (f"{made}/test/maps/more.png: is not in dataset_info.json",)

    (made / "test/maps/more.png").unlink()
    path = made / "dataset_info.json"
    info = json.loads(path.read_text())
    path.write_text(json.dumps({**info, "dataset_id": "0" * 64}))
    (fault,) = verify(made).faults
    assert fault.startswith(f"{path}: dataset_id is 0000000000000000..., the content has {info['dataset_id'][:16]}")


def test_lost_rows_are_told(made):
    path = made / "test/metadata.jsonl"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))

    assert any("has 5 rows, dataset_info.json says 6" in fault for fault in verify(made).faults)


def test_what_is_no_data_set_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="not a data set"):
        verify(tmp_path)


def test_the_command_ends_with_yes_or_no(made, capsys):
    assert console.run(app, "rectbench", ["verify", str(made), "-q"]) == 0
    told = capsys.readouterr().out
    assert "nothing wrong" in told
    assert f"id: {json.loads((made / 'dataset_info.json').read_text())['dataset_id']}" in told

    edit(made, "test", 2, overlap=0.2)
    assert console.run(app, "rectbench", ["verify", str(made), "-q"]) == 1
    shown = capsys.readouterr()
    assert "metadata.jsonl:2: overlap is 0.2" in shown.out
    assert "1 wrong" in shown.out


@pytest.mark.real
@pytest.mark.parametrize(("name", "rows"), [("real_maps", 168), ("real_lasers", 22)])
def test_the_real_data_sets_are_right(name, rows):
    if not (home := os.environ.get("RECTMERGE_REAL_MAPS")):
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder that holds real_maps and real_lasers")
    verdict = verify(Path(home) / name)

    assert (verdict.pairs, verdict.faults) == (rows, ())
