import pytest

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.cli.main import app
from scenarios.dataset.generate import SEED_STRIDE, generate, plan
from scenarios.dataset.writer import DataSetWriter
from scenarios.suites.spec import Seeds
from tests.scenarios.dataset.folders import contents
from tests.scenarios.tiny_suite import TinySuite

SUITE = TinySuite()
pytestmark = pytest.mark.usefixtures("no_picture")


def test_a_folder_with_another_data_set_is_refused_or_cleared(tmp_path):
    generate(SUITE, tmp_path / "set", pairs=3)
    with pytest.raises(InputError, match="finished data set"):
        generate(SUITE, tmp_path / "set", pairs=1, seed=1)

    generate(SUITE, tmp_path / "set", pairs=1, seed=1, force=True)
    generate(SUITE, tmp_path / "new", pairs=1, seed=1)
    assert contents(tmp_path / "set") == contents(tmp_path / "new")


def test_a_folder_with_something_else_is_refused_even_with_force(tmp_path):
    (tmp_path / "README.md").write_text("mine")

    with pytest.raises(InputError, match=r"holds something else \(README.md\)"):
        generate(SUITE, tmp_path, force=True)
    assert contents(tmp_path) == {"README.md": b"mine"}


@pytest.mark.parametrize(("pairs", "seed"), [(0, 0), (1, -1)])
def test_no_pairs_and_no_seed_are_refused(pairs, seed):
    with pytest.raises(InputError, match="pairs >= 1"):
        next(plan(SUITE, pairs=pairs, seed=seed))


def test_seeds_do_not_run_into_those_of_the_next_data_set():
    wide = TinySuite(seeds=Seeds(first=SEED_STRIDE - 2, count=3))

    with pytest.raises(InputError, match="seeds run out"):
        next(plan(wide))


def test_a_second_process_is_refused(tmp_path):
    generate(SUITE, tmp_path / "set", pairs=1)
    first = DataSetWriter(tmp_path / "set", {"suite": "mine"}, force=True)

    with first, pytest.raises(InputError, match="another process is writing"):
        generate(SUITE, tmp_path / "set", force=True)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere"], "no suite 'nowhere'"),
        (["smoke", "-o", "{file}"], "is a file"),
        (["smoke", "-o", "{held}"], "holds something else"),
    ],
)
def test_bad_input_is_one_line_and_status_2(tmp_path, capsys, words, message):
    (tmp_path / "held").mkdir()
    for name in ("file", "held/thing"):
        (tmp_path / name).touch()
    words = [word.format(file=tmp_path / "file", held=tmp_path / "held") for word in words]
    if "-o" not in words:
        words += ["-o", str(tmp_path / "out")]

    assert console.run(app, "rectbench", ["generate", *words, "--quiet"]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
