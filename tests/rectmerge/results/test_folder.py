"""Results of a merge replace earlier ones all at once or not at all, whatever happens in between."""

import os

import numpy as np
import pytest

from rectmerge.errors import InputError, MapFileError
from rectmerge.results.folder import ResultFolder
from tests import drawing

GREY = np.zeros((2, 2), np.uint8)
MERGED = drawing.building(resolution=0.05)
NEW = {  # what replaces a yes with its page: another yes, a no
    "yes": ({"n": 2}, {"overlay.png": GREY + 2, "conflict.png": GREY + 2}, drawing.building(resolution=0.10)),
    "no": ({"n": 2}, {"overlay_1.png": GREY + 2, "overlay_2.png": GREY + 2}, None),
}


def shown(folder):
    """What a reader finds: hidden files are not for them."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


@pytest.fixture
def earlier(tmp_path):
    """A folder with results."""
    ResultFolder(tmp_path).write({"n": 1}, {"overlay.png": GREY, "conflict.png": GREY}, MERGED)
    (tmp_path / "view.html").write_text("page")
    (tmp_path / "notes.txt").write_text("mine")
    return tmp_path


class Renames:
    """Stands in for both ways to rename; the one of a number is broken off, before or after it took place."""

    def __init__(self, monkeypatch, *, broken=-1, after=False, error=OSError, look=lambda: None):
        self.count, self.broken, self.after, self.error, self.look = 0, broken, after, error, look
        for name in ("rename", "replace"):
            monkeypatch.setattr(os, name, self.instead_of(getattr(os, name)))

    def instead_of(self, rename):
        def one(source, target, **options):
            if not os.path.lexists(source):
                raise FileNotFoundError(2, "there is none")
            number, self.count = self.count, self.count + 1
            if number == self.broken and not self.after:
                raise self.error(5, "broken off")
            rename(source, target, **options)
            self.look()
            if number == self.broken:
                raise self.error(5, "broken off")

        return one


@pytest.mark.parametrize(("error", "raised"), [(OSError, MapFileError), (KeyboardInterrupt, KeyboardInterrupt)])
@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("answer", NEW)
def test_whatever_rename_is_broken_off_the_earlier_results_are_all_there(earlier, answer, after, error, raised):
    before = {path.name: path.read_bytes() for path in earlier.iterdir()}
    broken = 0
    while True:
        with pytest.MonkeyPatch.context() as patch:
            renames = Renames(patch, broken=broken, after=after, error=error)
            try:
                ResultFolder(earlier).write(*NEW[answer])
            except raised:
                assert {path.name: path.read_bytes() for path in earlier.iterdir()} == before
                broken += 1
                continue
        break

    assert renames.count == broken >= 8  # each was broken off once, and none the last time
    assert b'"n": 2' in (earlier / "alignment.json").read_bytes()


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("answer", NEW)
def test_after_a_kill_at_any_rename_the_next_command_finds_all_old_or_all_new_results(tmp_path, caplog, answer, after):
    def write(folder, result):
        folder.mkdir()
        ResultFolder(folder).write({"n": 1}, {"overlay.png": GREY, "conflict.png": GREY}, MERGED)
        before = shown(folder)
        child = os.fork()  # a kill leaves no chance to put anything back
        if child == 0:
            with pytest.MonkeyPatch.context() as patch:
                Renames(patch, broken=result, after=after, error=lambda *_: os._exit(9))
                ResultFolder(folder).write(*NEW[answer])
                os._exit(0)
        return before, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

    states = []
    while True:
        folder = tmp_path / str(len(states))
        before, status = write(folder, len(states))
        caplog.clear()
        ResultFolder(folder).check([], force=True)
        states.append((shown(folder), shown(folder) == before))
        assert not [path for path in folder.iterdir() if path.name.startswith(".")]
        if status == 0:
            break
        assert ("are back" in caplog.text) or ("were completed" in caplog.text) or len(states) == 1

    whole, _ = states[-1]
    assert all(is_old or found == whole for found, is_old in states)
    assert len(states) >= 8


@pytest.mark.parametrize("answer", NEW)
def test_whoever_finds_an_answer_finds_its_results_whole(earlier, monkeypatch, answer):
    contents = [shown(earlier)]
    Renames(monkeypatch, look=lambda: contents.append(shown(earlier)))

    ResultFolder(earlier).write(*NEW[answer])

    whole = [contents[0], shown(earlier)]
    assert all(content in whole for content in contents if "alignment.json" in content)
    assert set(whole[1]) == {"alignment.json", "notes.txt", *NEW[answer][1]} | (
        {"merged.pgm", "merged.yaml"} if answer == "yes" else set()
    )
    assert not [path for path in earlier.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize("name", ["alignment.json", "conflict.png", "overlay_3.png"])
def test_a_folder_where_a_result_would_go_is_refused_and_all_stays(earlier, name):
    (earlier / name).unlink(missing_ok=True)
    (earlier / name).mkdir()
    before = {path.name for path in earlier.iterdir()}

    with pytest.raises(InputError, match=f"{name}: is a folder"):
        ResultFolder(earlier).check([], force=True)
    if name != "overlay_3.png":
        with pytest.raises(MapFileError, match=f"{name}: cannot be written: Is a directory"):
            ResultFolder(earlier).write(*NEW["yes"])
    assert {path.name for path in earlier.iterdir()} == before
