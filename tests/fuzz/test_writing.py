"""Full disks, shut folders, links and interrupts: results appear whole, or earlier ones stay whole."""

import errno
import os
import resource
import signal
import stat
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.fuzz import grids
from tests.fuzz.commands import BUILDINGS, check_whole, run, saved, start

NOBODY = 65534
OF_A_NO, OF_A_YES = 3, 5  # files of these merges' results, at least and exactly
SLOWED = """
import time, pathlib, rectmerge.cli
def slow_down(name):
    plain = getattr(pathlib.Path, name)
    def slowed(*args, **options):
        print(name, flush=True)
        time.sleep(0.2)
        return plain(*args, **options)
    setattr(pathlib.Path, name, slowed)
slow_down("write_bytes"), slow_down("replace"), slow_down("unlink")
"""


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def noisy(tmp_path) -> Path:
    """A map that fits nowhere."""
    return saved(grids.noise(60), tmp_path / "noisy.yaml")


@pytest.fixture
def earlier(tmp_path) -> Path:
    """A folder with the results of a yes."""
    assert run("merge", *BUILDINGS, "-o", tmp_path / "out").status == 0
    return tmp_path / "out"


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))  # Python ignores the signal that comes with it
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_files_that_cannot_grow_leave_earlier_results_whole(earlier, noisy):
    before = content(earlier)

    with largest_file(1000):
        ended = run("merge", BUILDINGS[0], noisy, "-o", earlier, "--force")

    assert ended.status == 2
    assert len(ended.err.splitlines()) == 1
    assert "cannot be written: File too large" in ended.err
    assert content(earlier) == before


@pytest.fixture
def small_disk(tmp_path) -> Iterator[Path]:
    disk = tmp_path / "disk"
    disk.mkdir()
    try:
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=100k", "tmpfs", disk], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no disk can be mounted here: {error}")
    yield disk
    subprocess.run(["umount", disk], check=True)


def test_a_full_disk_leaves_earlier_results_whole(small_disk, noisy):
    assert run("merge", *BUILDINGS, "-o", small_disk / "out").status == 0
    before = content(small_disk / "out")
    (small_disk / "else").write_bytes(bytes(os.statvfs(small_disk).f_bavail * 4096))

    ended = run("merge", BUILDINGS[0], noisy, "-o", small_disk / "out", "--force")

    assert ended.status == 2
    assert ended.err.rstrip().endswith("cannot be written: No space left on device")
    assert content(small_disk / "out") == before


@pytest.mark.parametrize("nth", range(OF_A_NO))
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()], ids=repr)
def test_whichever_file_fails_the_earlier_results_stay(earlier, noisy, monkeypatch, nth, error):
    before, plain, left = content(earlier), Path.write_bytes, [nth]

    def fail(self: Path, data: bytes) -> int:
        if left[0] == 0:
            plain(self, data[: len(data) // 2])
            raise error
        left[0] -= 1
        return plain(self, data)

    monkeypatch.setattr(Path, "write_bytes", fail)
    ended = run("merge", BUILDINGS[0], noisy, "-o", earlier, "--force")

    assert ended.status == (2 if isinstance(error, OSError) else 130)
    assert len(ended.err.splitlines()) == 1
    assert content(earlier) == before


@pytest.mark.parametrize("nth", range(OF_A_NO))
@pytest.mark.parametrize("name", ["replace", "unlink"])
def test_an_interrupt_between_two_names_is_a_moment_too_late(earlier, noisy, monkeypatch, name, nth):
    plain, left = getattr(Path, name), [nth]

    def interrupted(self: Path, *args: object, **options: object) -> object:
        left[0] -= 1
        if left[0] == -1:
            raise KeyboardInterrupt
        return plain(self, *args, **options)

    monkeypatch.setattr(Path, name, interrupted)
    ended = run("merge", BUILDINGS[0], noisy, "-o", earlier, "--force")

    assert ended.status == 130
    check_whole(earlier, is_merged=False)


MOMENTS = [("write_bytes", 1), ("write_bytes", 2), ("unlink", 1), ("unlink", 3)]
MOMENTS += [("replace", 1), ("replace", 2), ("replace", 3)]


@pytest.mark.parametrize(
    ("moment", "nth"),
    [("write_bytes", 3), *(pytest.param(*moment, marks=pytest.mark.slow) for moment in MOMENTS)],
)
def test_a_real_interrupt_ends_in_one_line(earlier, noisy, moment, nth):
    before = content(earlier)
    process = start(["merge", BUILDINGS[0], noisy, "-o", earlier, "--force", "--quiet"], SLOWED)
    assert process.stdout
    for line in process.stdout:
        nth -= line.strip() == moment
        if nth == 0:
            break

    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)

    assert (process.returncode, err) == (130, "rectmerge: interrupted\n")
    if moment == "write_bytes":
        assert content(earlier) == before
    else:
        check_whole(earlier, is_merged=False)


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.5])
def test_an_interrupt_at_any_time_leaves_earlier_or_later_results(earlier, noisy, seconds):
    before = content(earlier)
    ready = "import rectmerge.cli; print('ready', flush=True)"
    process = start(["merge", BUILDINGS[0], noisy, "-o", earlier, "--force", "--quiet"], ready)
    assert process.stdout
    process.stdout.readline()

    time.sleep(seconds)  # whatever it does by then; it may have ended
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)

    assert process.returncode in (130, 1)
    assert err == ("rectmerge: interrupted\n" if process.returncode == 130 else "")
    if content(earlier) != before:
        check_whole(earlier, is_merged=False)


@contextmanager
def nobody() -> Iterator[None]:
    """Work as somebody who may not write everywhere: root may."""
    if os.getuid():
        yield
        return
    os.setresuid(NOBODY, NOBODY, 0)
    try:
        yield
    finally:
        os.setresuid(0, 0, 0)


@pytest.mark.parametrize("mode", [0o555, 0o000])
@pytest.mark.parametrize("name", [".", "new", "a/b"])
def test_a_folder_that_may_not_be_written_is_one_line(tmp_path, mode, name):
    run("merge", *BUILDINGS, "-o", tmp_path / "warm")  # imports everything
    folder = tmp_path / "shut"
    folder.mkdir()
    folder.chmod(mode)
    if os.getuid() == 0:
        for parent in (tmp_path, tmp_path.parent, tmp_path.parent.parent):
            parent.chmod(parent.stat().st_mode | stat.S_IXOTH)

    with nobody():
        if not os.access(BUILDINGS[0], os.R_OK):
            pytest.skip("the tests' own maps cannot be read by others")
        ended = run("merge", *BUILDINGS, "-o", folder / name)

    folder.chmod(0o755)
    assert ended.status == 2
    assert ended.err == f"rectmerge: {folder / name}: cannot be written; name another folder with -o\n"
    assert not list(folder.iterdir())


def test_outputs_that_are_no_folder_are_refused(tmp_path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "to file").symlink_to("file")
    (tmp_path / "to nothing").symlink_to("nowhere")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "held" / "merged.yaml").mkdir(parents=True)

    for name in ("file", "to file", "to nothing", "loop", "held", "file/below", "n" * 300):
        ended = run("merge", *BUILDINGS, "-o", tmp_path / name, "--force")
        assert (ended.status, len(ended.err.splitlines())) == (2, 1), ended

    assert (tmp_path / "file").read_text() == "mine"
    assert not (tmp_path / "nowhere").exists()


def test_results_go_through_a_link_to_a_folder(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder")

    assert run("merge", *BUILDINGS, "-o", tmp_path / "link").status == 0
    check_whole(tmp_path / "folder", is_merged=True)


def test_an_input_that_a_link_to_the_folder_leads_to_is_refused(tmp_path, earlier):
    (tmp_path / "link").symlink_to(earlier)
    before = content(earlier)

    ended = run("merge", earlier / "merged.yaml", BUILDINGS[1], "-o", tmp_path / "link", "--force")

    assert ended.status == 2
    assert "is an input" in ended.err
    assert content(earlier) == before


def test_a_result_that_is_a_link_is_replaced_and_not_what_it_leads_to(tmp_path, noisy):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "merged.pgm").symlink_to(noisy.with_suffix(".pgm"))
    before = noisy.with_suffix(".pgm").read_bytes()

    assert run("merge", *BUILDINGS, "-o", tmp_path / "out", "--force").status == 0
    assert noisy.with_suffix(".pgm").read_bytes() == before
    check_whole(tmp_path / "out", is_merged=True)
