import re
import shlex
import shutil
from pathlib import Path

import pytest
import typer

import rectmerge as rm
from rectmerge.cli import console
from rectmerge.cli import main as cli
from scenarios.cli import main as bench_cli

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = sorted(ROOT.glob("*.md"))
APPS = {"rectmerge": cli.app, "rectbench": bench_cli.app}
COMMANDS = [
    shlex.split(line, comments=True)
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
]
ROWS = [line for line in README.partition("## Results")[2].splitlines() if line.startswith("| ") and "](" in line]


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder in which the README's paths are found and what it writes does no harm."""
    shutil.copytree(ROOT / "tests" / "data", tmp_path / "tests" / "data")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_library_example_merges_the_maps(checkout, capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)

    exec(example, {})

    merged, alone = rm.read_map("merged.yaml"), rm.read_map("tests/data/building_a.yaml")
    assert merged.resolution == alone.resolution
    assert merged.occupied.sum() > alone.occupied.sum()  # by default a wall of either map is a wall
    assert capsys.readouterr().out.startswith("Similarity(")  # not "rejected ..."


@pytest.mark.slow
def test_the_examples_of_rectmerge_answer_yes_one_after_the_other(checkout):
    for words in (words for words in COMMANDS if words[0] == "rectmerge"):
        assert console.run(APPS["rectmerge"], "rectmerge", words[1:]) == console.YES, shlex.join(words)


@pytest.mark.parametrize("words", COMMANDS, ids=shlex.join)
def test_every_example_is_understood(words):
    group = typer.main.get_command(APPS[words[0]])

    assert group.commands[words[1]].make_context(words[1], words[2:])  # raises a usage error otherwise


@pytest.mark.parametrize("name", APPS)
def test_every_command_is_in_the_readme(name):
    assert set(typer.main.get_command(APPS[name]).commands) <= set(re.findall(rf"{name} ([a-z-]+)", README))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_to_files_lead_somewhere(page):
    links = re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8"))

    missing = [link for link in links if not link.startswith("https://") and not (ROOT / link).exists()]
    assert not missing


def test_the_picture_is_small():
    assert (ROOT / "docs" / "demo.png").stat().st_size < 300_000


@pytest.mark.parametrize("row", ROWS)
def test_the_figures_are_those_of_the_results(row):
    (page,) = re.findall(r"\]\((results/[^)]+)\)", row)
    figures = re.findall(r"\d+ of \d+|\d+\.\d+", row)

    text = (ROOT / page).read_text(encoding="utf-8")
    assert figures
    assert [figure for figure in figures if not re.search(rf"\b{re.escape(figure)}\b", text)] == []


def test_the_results_are_in_the_readme():
    linked = {page for row in ROWS for page in re.findall(r"results/(\w+)", row)}

    assert linked == {"README", "fleets", "headline", "live", "robust", "storeys", "trust", "unbending"}


def test_version_is_one():
    versions = re.findall(r'^version(?: = |: )"?([\d.]+)"?$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    versions += re.findall(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)

    assert versions == [rm.__version__] * 2
