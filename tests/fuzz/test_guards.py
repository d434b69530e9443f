"""Files that are no images, and images that no memory holds: refused in one line, at once, in little memory."""

import os
from pathlib import Path

import pytest

from tests.fuzz import files
from tests.fuzz.commands import BUILDINGS, run, start

SIDE, MOST_MB, LIMIT_SECONDS = 20_000, 400, 20
TELL_MEMORY = """
import atexit, pathlib, sys
def peak():  # of this process alone: what getrusage tells begins with its parent's
    return next(line.split()[1] for line in pathlib.Path("/proc/self/status").open() if line.startswith("VmHWM"))
atexit.register(lambda: print(int(peak()) // 1024, file=sys.stderr))
"""
NAMES = ["../../../../../../etc/passwd", "/etc/passwd", "folder", "pipe", "/dev/zero", "/dev/stdin", "loop", "nowhere"]
NAMES += ["to nowhere", "..", "/", "map.yaml", "map.yaml/x", "/proc/self/environ", "n" * 300]


def described(image: Path) -> Path:
    path = image.with_suffix(".yaml")
    path.write_text(f"image: '{image.name}'\nresolution: 0.05\norigin: [0, 0, 0]\n{SOUND}")
    return path


SOUND = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.mark.parametrize("kind", ["png", "pgm"])
def test_twenty_thousand_cells_a_side_are_refused_at_once_and_in_little_memory(tmp_path, kind):
    image = tmp_path / f"large.{kind}"
    if kind == "png":
        image.write_bytes(files.empty_png(SIDE))
    else:
        image.write_bytes(b"P5 %d %d 255\n" % (SIDE, SIDE))
        os.truncate(image, SIDE * SIDE + 100)  # a file with a hole

    process = start(["merge", described(image), BUILDINGS[1], "-o", tmp_path / "out"], TELL_MEMORY)
    _, err = process.communicate(timeout=LIMIT_SECONDS)

    message, memory = err.splitlines()
    assert process.returncode == 2
    assert message.endswith("more than 150 million; crop it to its known cells")
    assert int(memory) < MOST_MB
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", NAMES)
def test_an_image_that_is_none_is_one_line(tmp_path, name):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "to nowhere").symlink_to("nowhere")
    (tmp_path / "map.yaml").write_text(f"image: '{name}'\nresolution: 0.05\norigin: [0, 0, 0]\n{SOUND}")

    for words in (["merge", tmp_path / "map.yaml", BUILDINGS[1]], ["inspect", tmp_path / "map.yaml"]):
        ended = run(*words, "-o", tmp_path / "out.png")

        assert (ended.status, len(ended.err.splitlines())) == (2, 1), ended
        assert ended.err.startswith(f"rectmerge: {tmp_path / 'map.yaml'}: its image ")
        assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("name", ["folder", "pipe", "loop", "nowhere", "n" * 300, ""])
def test_a_map_that_is_no_file_is_one_line(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")

    ended = run("merge", name, BUILDINGS[1], "-o", "out")

    assert (ended.status, len(ended.err.splitlines())) == (2, 1), ended
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["", "[" * 100_000, "{}", "null", '{"verdict": 1}', '{"verdict": "accepted"}', "\x00"])
def test_an_answer_that_is_none_is_one_line(tmp_path, text):
    (tmp_path / "alignment.json").write_text(text)

    for words in (["transform", tmp_path], ["merge", *BUILDINGS, "--from", tmp_path, "-o", tmp_path / "out"]):
        ended = run(*words)
        assert (ended.status, len(ended.err.splitlines())) == (2, 1), ended


@pytest.mark.parametrize("name", ["points.csv", "points.json"])
@pytest.mark.parametrize(
    "text", ["", "x,y\n1", "a,b\n", "1e400,nan\n", "[" * 100_000, '{"coordinates": [1e999]}', "\x00"]
)
def test_points_that_are_none_are_one_line(tmp_path, name, text):
    run("merge", *BUILDINGS, "-o", tmp_path / "out")
    (tmp_path / name).write_text(text)

    ended = run("transform", tmp_path / "out", "--points", tmp_path / name)

    assert (ended.status, len(ended.err.splitlines())) == (2, 1), ended
