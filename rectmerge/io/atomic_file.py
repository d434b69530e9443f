"""Atomic replacement of files: a name never holds half a file."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from rectmerge.errors import InputError, MapFileError


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
