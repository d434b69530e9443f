"""Files that commands write: never over earlier results unasked, never half."""

from __future__ import annotations

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


def write_json(path: Path, content: Any) -> None:
    """Write JSON so that its name never shows half of it."""
    replace_file(path, f"{to_json(content)}\n".encode())
