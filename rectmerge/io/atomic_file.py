"""Atomic replacement of files: a name never holds half a file."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from rectmerge.errors import InputError, MapFileError


def real(path: Path) -> Path:
    """Resolve a path's links, as far as that goes: of a link to itself its own name stays."""
    return Path(os.path.realpath(path))


def require_other(output: Path, inputs: Iterable[Path]) -> None:
    """Raise InputError where what is to be written is a file that is read, by whatever name."""
    if real(output) in map(real, inputs):
        raise InputError(f"{output}: is an input, and would be replaced; name another file with -o")


def replace_file(path: Path, data: bytes) -> None:
    """Write a file so that its name never holds half of it.

    Raises
    ------
    MapFileError
        If it cannot be written.
    """
    replace_files({path: data})


def replace_files(files: Mapping[Path, bytes], *, stale: Iterable[Path] = ()) -> None:
    """Write files so that no name ever holds half of one, and where one cannot be written all stay as they were.

    Parameters
    ----------
    files
        What goes where; the names appear in this order. Of several, no earlier one is left when the first new one
        appears: whoever finds the last finds the others as they belong to it.
    stale
        Files that go as well.

    Raises
    ------
    MapFileError
        If one cannot be written.
    """
    partials = {path: _hidden(path, "part") for path in files}
    earlier = {path: _hidden(path, "old") for path in [*reversed([*files]), *stale]}
    if len(earlier) == 1:
        earlier = {}  # one file is replaced in one step
    path = Path()
    try:
        for path, partial in partials.items():
            _require_no_folder(path)
            partial.write_bytes(files[path])
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


def _require_no_folder(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():  # it could be set aside like a file, with all it holds
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _hidden(path: Path, suffix: str) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.{suffix}")


def _put_back(earlier: Mapping[Path, Path], fresh: Iterable[Path]) -> None:
    """Undo a replacement that broke off; what went first comes back last, so that it stands for the others again."""
    _remove(fresh)
    for path, old in reversed([*earlier.items()]):
        with contextlib.suppress(OSError):  # what does not come back stays beside, under its hidden name
            if os.path.lexists(old):
                old.replace(path)


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
