"""Atomic replacement of files: a name never holds half a file."""

from __future__ import annotations

import contextlib
import errno
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from rectmerge.errors import InputError, MapFileError

FIRST = 1  # number of the new file that takes its name first
HIDDEN = re.compile(r"\.(?P<name>.+)\.(?P<process>\d+)\.(?P<kind>old|\d+\.part)")  # as `_hidden` names them


def resolve_links(path: Path) -> Path:
    """Resolve the links of a path; a link to itself keeps its own name."""
    return Path(os.path.realpath(path))


def require_other(output: Path, inputs: Iterable[Path]) -> None:
    """Raise InputError if the output is one of the inputs, by any name."""
    if resolve_links(output) in map(resolve_links, inputs):
        raise InputError(f"{output}: is an input, and would be replaced; name another file with -o")


def replace_file(path: Path, data: bytes) -> None:
    """Write a file in one step: its name never holds half of it.

    Raises
    ------
    MapFileError
        If it cannot be written.
    """
    replace_files({path: data})


def replace_files(files: Mapping[Path, bytes], *, stale: Iterable[Path] = ()) -> None:
    """Write files in one step: no name ever holds half of one; if one cannot be written, all stay as they were.

    Parameters
    ----------
    files
        Contents by path; the names appear in this order. Of several, all old ones are gone before the first new one
        appears: a reader that finds the last finds the others that belong to it.
    stale
        Files to be removed as well.

    Raises
    ------
    MapFileError
        If one cannot be written.
    """
    partials = {path: _hidden(path, f"{number}.part") for number, path in enumerate(files, start=FIRST)}
    earlier = {path: _hidden(path, "old") for path in [*reversed([*files]), *stale]}
    if len(earlier) == 1:
        earlier = {}  # one file is replaced in one step
    path = Path()
    try:
        for path, partial in partials.items():
            _require_no_folder(path)
            _write_through(partial, files[path])
        fresh = [path for path in files if not os.path.lexists(path)]
        try:
            for path, old in earlier.items():
                with contextlib.suppress(FileNotFoundError):
                    path.rename(old)
            for path, partial in partials.items():
                partial.replace(path)
        except BaseException:
            _put_back(earlier, fresh)
            raise
    except OSError as error:
        raise MapFileError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        _remove(partials.values())
    _remove(earlier.values())


def finish_interrupted(folder: Path) -> str:
    """Finish or undo a replacement in a folder whose process was killed in the middle.

    Returns
    -------
    str
        What was done, for the user; empty where there was nothing to do.

    Notes
    -----
    New files are complete before the first old one is set aside. So while the first new file has not taken its name,
    the old ones are put back; after that, the other new ones take theirs.
    """
    left = _left_behind(folder)
    processes = {int(match["process"]) for match in left.values()}
    done = [_finish(folder, {p: m for p, m in left.items() if int(m["process"]) == each}) for each in sorted(processes)]
    return "; ".join(filter(None, done))


def _left_behind(folder: Path) -> dict[Path, re.Match[str]]:
    """Return the hidden files of processes that no longer run."""
    with contextlib.suppress(OSError):
        names = {path: HIDDEN.fullmatch(path.name) for path in sorted(folder.iterdir())}
        return {path: match for path, match in names.items() if match and not _is_running(int(match["process"]))}
    return {}


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _finish(folder: Path, left: Mapping[Path, re.Match[str]]) -> str:
    """Finish or undo one replacement; return what was done."""
    olds = {path: folder / match["name"] for path, match in left.items() if match["kind"] == "old"}
    news = {int(match["kind"].partition(".")[0]): path for path, match in left.items() if match["kind"] != "old"}
    is_begun = bool(olds or news) and FIRST not in news
    try:
        if is_begun:
            for _, path in sorted(news.items()):
                path.replace(folder / left[path]["name"])
        else:
            for path, name in olds.items():
                path.replace(name)
    except OSError as error:
        raise MapFileError(f"{folder}: an interrupted command left it unfinished: {error.strerror or error}") from None
    _remove(left)
    if is_begun:
        return "the new results of an interrupted command were completed"
    return "the earlier results, which an interrupted command had set aside, are back" if olds else ""


def _write_through(path: Path, data: bytes) -> None:
    """Write a file and have it on the disk: a name must not survive a power cut that its content does not."""
    path.write_bytes(data)
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _require_no_folder(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():  # a rename would set it aside like a file, with its content
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _hidden(path: Path, suffix: str) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.{suffix}")


def _put_back(earlier: Mapping[Path, Path], fresh: Iterable[Path]) -> None:
    """Undo a replacement that broke off, in reverse order: the last file comes back when the others are there."""
    _remove(fresh)
    for path, old in reversed([*earlier.items()]):
        with contextlib.suppress(OSError):  # a file that cannot come back keeps its hidden name
            if os.path.lexists(old):
                old.replace(path)


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
