"""docs/add-a-method.md, done as it says in a folder of its own."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from scenarios.bench.mistakes import MISTAKES

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "add-a-method.md").read_text(encoding="utf-8")
COMMANDS = [
    shlex.split(line) for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL) for line in block.splitlines()
]


@pytest.fixture
def folder(tmp_path):
    """The page's files, and what `pip install` writes for the entry point."""
    names = re.findall(r"`(my_\w+\.py)`", PAGE)
    for name, code in zip(names, re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL), strict=True):
        (tmp_path / name).write_text(code)
    project = tomllib.loads(*re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL))["project"]
    installed = tmp_path / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text(f"Name: {project['name']}\nVersion: {project['version']}\n")
    ((group, points),) = project["entry-points"].items()
    listed = "\n".join(f"{name} = {value}" for name, value in points.items())
    (installed / "entry_points.txt").write_text(f"[{group}]\n{listed}\n")
    return tmp_path


@pytest.mark.slow  # a process each, and a dozen more of the program
@pytest.mark.parametrize("words", COMMANDS, ids=shlex.join)
def test_the_page_done_as_written_makes_a_method_that_passes(folder, words):
    command = Path(sys.executable).with_name(words[0])
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    env = {**os.environ, "PYTHONPATH": str(folder), "PATH": path}

    done = subprocess.run([command, *words[1:]], cwd=folder, env=env, capture_output=True, text=True, check=False)

    assert done.stdout.endswith("all is well\n"), done.stdout + done.stderr
    assert done.returncode == 0


def test_the_page_names_every_mistake():
    table = PAGE.partition("| mistake |")[2]

    missing = [mistake.name for mistake in MISTAKES if mistake.name.removeprefix("v flipped ") not in table]
    assert not missing
