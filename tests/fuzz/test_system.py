"""What the machine does to a merge: full disks, folders that cannot be written, links, and Ctrl-C at any moment."""

import contextlib
import io
import itertools
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.cli import console
from tests import drawing
from tests.fuzz import grids
from tests.fuzz.commands import run, save

A, B = (drawing.DATA / f"building_{name}.yaml" for name in "ab")
COMMAND = [sys.executable, "-c", "from rectmerge.cli.main import main; main()"]
ROOT = Path(__file__).parents[2]
OURS = re.compile(r'File ".*(?:rectmerge|scenarios)/[^"]+", line \d+, in (?!<module>)')  # a call of ours in a traceback


def started(*words, **options):
    """Start the command as a process of its own."""
    return subprocess.Popen(
        [*COMMAND, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        **options,
    )


def held(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def before(tmp_path):
    """A folder with results, and what it holds."""
    assert run("merge", A, B, "-o", tmp_path / "out", "-q") == console.YES
    return tmp_path / "out", held(tmp_path / "out")


@pytest.fixture
def full_disk(tmp_path):
    """A disk with room for less than the results."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=24k", "tmpfs", str(disk)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("a small disk can only be mounted by root")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def test_a_full_disk_is_told_and_leaves_nothing_half(full_disk, capsys):
    assert run("merge", A, B, "-o", full_disk / "out") == console.BAD_INPUT

    assert capsys.readouterr().err.strip().endswith("No space left on device")
    assert held(full_disk / "out") == {}


def test_earlier_results_outlive_a_full_disk(before, full_disk, capsys):
    shutil.copy(before[0] / "alignment.json", full_disk)
    whole = held(full_disk)

    assert run("merge", A, B, "-o", full_disk, "--force") == console.BAD_INPUT
    assert held(full_disk) == whole


@pytest.mark.slow
def test_files_that_may_not_grow_leave_earlier_results_whole(before):
    folder, whole = before

    def small_files():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

    process = started("merge", A, B, "-o", folder, "--force", preexec_fn=small_files)
    _, err = process.communicate(timeout=120)

    assert process.returncode == console.BAD_INPUT
    assert err.strip().endswith("cannot be written: File too large")
    assert held(folder) == whole


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody who may not write there")
def test_a_folder_that_may_not_be_written_is_refused(tmp_path, before):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o755)
    for path in itertools.takewhile(lambda path: path != Path(tempfile.gettempdir()), (tmp_path, *tmp_path.parents)):
        path.chmod(0o755)
    maps = [shutil.copy(path.with_suffix(suffix), tmp_path) for path in (A, B) for suffix in (".pgm", ".yaml")]

    child = os.fork()  # all that is needed is loaded by now: nobody else may read where it lies
    if child == 0:
        os.setgid(65534)
        os.setuid(65534)
        status = console.BAD_INPUT if _refused(maps[1], maps[3], locked / "out") else console.INTERNAL
        os._exit(status)

    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == console.BAD_INPUT
    assert held(locked) == {}


def _refused(a, b, folder):
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        status = run("merge", a, b, "-o", folder)
    wanted = f"rectmerge: {folder}: cannot be written; name another folder with -o"
    return status == console.BAD_INPUT and said.getvalue().strip() == wanted


@pytest.mark.slow
@pytest.mark.parametrize("moment", [0.05, 0.4, 0.8, 1.3])
def test_an_interrupt_at_any_moment_is_one_line_and_nothing_half(tmp_path, before, moment):
    folder, whole = before
    a, b = (save(tmp_path, name, grids.noise(400, 0.1, 0.05, seed)) for seed, name in enumerate("ab"))
    process = started("merge", a, b, "-o", folder, "--force", "-q")
    time.sleep(moment)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)

    if "Traceback" in err:
        assert not OURS.search(err)  # Python itself was starting, or importing: nothing of ours had been called
    elif process.returncode == console.INTERRUPTED:
        assert err.splitlines() == ["rectmerge: interrupted"]
        assert held(folder) == whole
    else:  # it came after the answer: at worst while Python was closing down
        assert process.returncode in (console.YES, console.NO, console.AMBIGUOUS, -signal.SIGINT)
        assert held(folder)["alignment.json"] != whole["alignment.json"]
    assert not [name for name in held(folder) if name.endswith(".part")]


def test_results_go_through_a_link_to_a_folder_and_not_over_what_a_link_leads_to(tmp_path, capsys):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    (tmp_path / "precious").write_text("mine")
    (tmp_path / "real" / "overlay.png").symlink_to(tmp_path / "precious")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")

    assert run("merge", A, B, "-o", tmp_path / "link", "--force") == console.YES
    assert (tmp_path / "precious").read_text() == "mine"
    assert not (tmp_path / "real" / "overlay.png").is_symlink()
    assert run("merge", A, B, "-o", tmp_path / "dangling") in (console.YES, console.BAD_INPUT)
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.slow
def test_names_that_cannot_be_are_refused_in_one_line(tmp_path, capsys):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    deep = "[" * 100_000
    (tmp_path / "deep.geojson").write_text(deep)
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "alignment.json").write_text(deep)
    assert run("merge", A, B, "-o", tmp_path / "good", "-q") == console.YES
    capsys.readouterr()

    for words in (
        ("merge", A, B, "-o", tmp_path / "loop"),
        ("merge", A, B, "-o", tmp_path / "loop" / "out"),
        ("merge", A, B, "-o", tmp_path / ("x" * 300)),
        ("merge", tmp_path / "loop", B, "-o", tmp_path / "out"),
        ("merge", tmp_path / ("y" * 300), B, "-o", tmp_path / "out"),
        ("inspect", A, "-o", tmp_path / "loop" / "p.png"),
        ("transform", tmp_path / "deep"),
        ("transform", tmp_path / "loop"),
        ("transform", tmp_path / "good", "--points", tmp_path / "deep.geojson"),
        ("view", tmp_path / "deep", "--no-open"),
    ):
        assert run(*words) == console.BAD_INPUT, words
        assert len(capsys.readouterr().err.strip().splitlines()) == 1, words


@pytest.mark.slow
def test_a_map_too_large_is_refused_by_its_header_and_costs_no_memory(tmp_path):
    Image.new("1", (20_000, 20_000)).save(tmp_path / "large.png")
    process = started("merge", tmp_path / "large.png", B, "-o", tmp_path / "out")
    _, err = process.communicate(timeout=60)

    assert process.returncode == console.BAD_INPUT
    assert err.strip().endswith("400000000 pixels by its header, more than 150 million; crop it to its known cells")
    assert not (tmp_path / "out").exists()
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 2_000_000  # KB, of the largest child so far


@pytest.mark.slow
def test_time_grows_no_faster_than_the_cells(tmp_path):
    def seconds(side):
        cells = np.kron(drawing.building().occupancy, np.ones((side // 100, side // 100), np.int8))
        path = save(tmp_path, f"map{side}", cells)
        return min(_timed("merge", path, path, "-o", tmp_path / f"out{side}", "--force", "-q") for _ in range(2))

    def _timed(*words):
        at = time.process_time()
        assert run(*words) in (0, 1, 3)
        return time.process_time() - at

    assert seconds(1600) < 16 * 2 * seconds(400)  # 16 times the cells
