"""Every snippet of the documentation runs: Python, `rectmerge` in order, and `rectbench` where it takes no hours."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer

import rectmerge as rm
from rectmerge.cli import console
from rectmerge.cli import main as cli
from scenarios.cli import docs_page as commandpage
from scenarios.cli import main as bench_cli
from tests.marking import some_slow
from tests.rectmerge import bags

ROOT = Path(__file__).parents[1]
PAGES = {page.name: page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").glob("*.md"))}
TESTED_ELSEWHERE = {"add-a-method.md", "simulation.md"}  # by test_add_a_method.py and test_docs.py
WITHOUT_LIBRARIES = {"data-sets.md"}  # whose Python needs libraries that may be missing: by test_data_sets_page.py
# what a line names that would take hours, or minutes
HOURS = ("sets/standard", "runs/standard", "sets/fleet-3", "sets/grid", "runs/grid")
APPS = {"rectmerge": cli.app, "rectbench": bench_cli.app}


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", PAGES[page], re.DOTALL)


def lines_of(page, program):
    """The words of a page's lines of one program, and the status they are said to end with."""
    for line in "".join(blocks(page, "sh")).splitlines():
        words = shlex.split(line, comments=True)
        if words[:1] == [program]:
            status = re.search(r"# .*status (\d+)", line)
            yield words, int(status[1]) if status else console.YES


def having(program):
    return [page for page in PAGES if page not in TESTED_ELSEWHERE and any(lines_of(page, program))]


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder in which the pages' files are found and what they write does no harm, with a bag of both maps."""
    shutil.copytree(ROOT / "tests" / "data", tmp_path / "tests" / "data")
    monkeypatch.chdir(tmp_path)
    messages = []
    for robot, name in (("robot1", "building_a"), ("robot2", "building_b")):
        grid = rm.read_map(f"tests/data/{name}.yaml")
        x, y, yaw = grid.origin
        content = {"cells": grid.occupancy, "resolution": grid.resolution, "at": (x, y, 0.0), "turn": bags.level(yaw)}
        messages.append((f"/{robot}/map", bags.GRID, content))
    shutil.copy(bags.storage(bags.write(tmp_path, "mcap", messages)), "run.mcap")
    return tmp_path


PYTHON = [page for page in PAGES if page not in TESTED_ELSEWHERE | WITHOUT_LIBRARIES and blocks(page, "python")]


@pytest.mark.parametrize("page", PYTHON)
def test_python_runs(checkout, page):
    names: dict[str, object] = {}
    for block in blocks(page, "python"):
        exec(block, names)


@pytest.mark.parametrize("page", some_slow(having("rectmerge"), "view.md"))
def test_rectmerge_answers_as_told(checkout, page):
    for words, status in lines_of(page, "rectmerge"):
        assert console.run(cli.app, "rectmerge", words[1:]) == status, shlex.join(words)


@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.parametrize("page", having("rectbench"))
def test_rectbench_answers_as_told(checkout, page):
    for words, status in lines_of(page, "rectbench"):
        if not any(word.startswith(HOURS) for word in words):
            assert console.run(bench_cli.app, "rectbench", words[1:]) == status, shlex.join(words)


@pytest.mark.parametrize("page", having("rectbench"))
def test_rectbench_understands(page):
    group = typer.main.get_command(bench_cli.app)

    for words, _ in lines_of(page, "rectbench"):
        assert group.commands[words[1]].make_context(words[1], words[2:])  # raises a usage error otherwise


def test_the_page_of_commands_is_that_of_these_commands():
    assert PAGES["commands.md"] == commandpage.page()  # `make docs` renews it


@pytest.mark.slow
def test_the_site_is_built_and_holds_every_page(tmp_path):
    words = [Path(sys.executable).parent / "mkdocs", "build", "--strict", "--quiet", "--site-dir", tmp_path]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)

    assert done.returncode == 0, done.stderr
    menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert [page for page in PAGES if f": {page}\n" not in menu + "\n"] == []
