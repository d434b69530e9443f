"""Files that commands write: never over earlier results unasked, never half."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.json_text import to_json


def clear_folder(out: str | Path, names: Sequence[str], *, force: bool) -> Path:
    """Make a folder for results; files of these names or patterns in it are refused, or cleared with `force`."""
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; results go into a folder")
    stale = [path for name in names for path in sorted(folder.glob(name)) if path.is_file()]
    if stale and not force:
        raise InputError(f"{folder}: holds earlier results ({stale[0].name}); --force clears them")
    try:
        for path in stale:
            path.unlink()
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from error
    return folder


def require_place(file: str | Path) -> None:
    """Make the folder of a file that comes after long work; refuse at once what could not be written then."""
    path = Path(file)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file with -o")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot be written: {path.parent} is read-only")


def write_json(path: Path, content: Any) -> None:
    """Write JSON so that its name never shows half of it."""
    replace_file(path, f"{to_json(content)}\n".encode())
