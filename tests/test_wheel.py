"""The built wheel in an empty environment: the merging works alone, and what is missing is named with its remedy."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DATA = ROOT / "tests" / "data"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The commands' folder of an environment that holds the wheel and what it requires, nothing else."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, timeout=300)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", str(folder / "env")], check=True, timeout=120)
    install = [folder / "env" / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-compile", str(wheel)]
    subprocess.run(install, check=True, timeout=600)
    return folder / "env" / "bin"


def run(command, *words, cwd):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return subprocess.run(
        [command, *map(str, words)], capture_output=True, text=True, cwd=cwd, env=environment, timeout=300, check=False
    )


def test_maps_are_merged_without_the_simulator(installed, tmp_path):
    done = run(
        installed / "rectmerge", "merge", DATA / "building_a.yaml", DATA / "building_b.yaml", "-o", "out", cwd=tmp_path
    )

    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "merged.yaml").exists()
    assert done.stderr.count("compiling inner loops") == 1  # one wait, for all that a merge uses
    assert "inner loops compiled, about" in done.stderr
    assert run(installed / "python", "-c", "import pybullet", cwd=tmp_path).returncode == 1
    bent = ("--unbend", "always", "--force")
    again = run(
        installed / "rectmerge",
        "merge",
        *(DATA / f"building_{name}.yaml" for name in "ab"),
        "-o",
        "out",
        *bent,
        cwd=tmp_path,
    )
    assert again.returncode == 0, again.stderr
    assert "compiling" not in again.stderr


@pytest.mark.parametrize("words", ["generate smoke -o set", "run smoke -o run", "demo -o demo", "figures -o figures"])
def test_what_needs_the_simulator_says_how_to_install_it(installed, tmp_path, words):
    done = run(installed / "rectbench", *words.split(), cwd=tmp_path)

    assert done.returncode == 2
    assert done.stderr.startswith("rectbench: this needs pybullet")
    assert "pip install 'rectmerge[sim]'" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_bag_says_how_to_install_what_reads_it(installed, tmp_path):
    (tmp_path / "run.mcap").write_bytes(bytes(100))

    done = run(installed / "rectmerge", "inspect", "run.mcap:/map", "-o", "picture.png", cwd=tmp_path)

    assert done.returncode == 2
    assert "pip install 'rectmerge[ros]'" in done.stderr
