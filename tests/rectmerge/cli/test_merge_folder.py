"""The folder of the results: what `merge` replaces, clears and refuses."""

import shutil

import pytest

from tests.rectmerge.cli.answers import YES_FILES, A, B, names, rectmerge

pytestmark = pytest.mark.usefixtures("small_pictures")


def test_results_are_not_replaced_without_force(tmp_path, answer, capsys):
    answer("accepted")
    rectmerge("merge", A, B, "-o", tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    assert rectmerge("merge", A, B, "-o", tmp_path) == 2

    assert "--force" in capsys.readouterr().err
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_force_leaves_no_stale_map_beside_a_new_no_and_nothing_else_is_touched(tmp_path, answer):
    answer("accepted")
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "overlay_old.png").write_text("mine too")
    rectmerge("merge", A, B, "-o", tmp_path)
    answer("rejected")

    assert rectmerge("merge", A, B, "-o", tmp_path, "--force") == 1

    assert names(tmp_path) == {"alignment.json", "overlay_1.png", "notes.txt", "overlay_old.png"}


def test_inputs_in_the_folder_of_the_results_stay_as_they_are(tmp_path, answer):
    answer("accepted")
    for file in (A, A.with_suffix(".pgm"), B, B.with_suffix(".pgm")):
        shutil.copy(file, tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    assert rectmerge("merge", tmp_path / A.name, tmp_path / B.name, "-o", tmp_path) == 0

    assert names(tmp_path) == YES_FILES | set(before)
    assert all((tmp_path / name).read_bytes() == data for name, data in before.items())


@pytest.mark.parametrize("as_b", [False, True])
def test_an_input_that_a_result_would_replace_is_refused_even_with_force(tmp_path, answer, capsys, as_b):
    answer("accepted")
    rectmerge("merge", A, B, "-o", tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    merged = tmp_path / "merged.yaml"

    assert rectmerge("merge", *((A, merged) if as_b else (merged, B)), "-o", tmp_path, "--force") == 2

    assert "is an input" in capsys.readouterr().err
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 2
    assert rectmerge("merge", A, B, "-o", tmp_path / "out" / "deeper") == 2
    assert (tmp_path / "out").read_text() == "mine"
