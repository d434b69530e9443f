"""Id of a data set: the hash of its content, whatever the folder is called and whoever made it.

The content is every file in the folders of its splits (in its own folder where rows lie there), apart from hidden files
and from those that describe it: README.md, pairs.png and dataset_info.json of its own folder. The id is the SHA-256 of
the lines that sha256sum prints of these files, in the order of their paths.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from rectmerge.errors import DatasetError
from scenarios.dataset.metadata import METADATA
from scenarios.dataset.reader import SPLITS, split_folders

CARD, PICTURE, INFO = "README.md", "pairs.png", "dataset_info.json"
DESCRIBING = (CARD, PICTURE, INFO)
SHOWN_DIGITS = 16  # of an id, where people read it


def dataset_root(path: str | Path) -> Path:
    """Return the folder of a data set by its own path or that of one of its splits."""
    named = Path(path)
    return named.parent if named.resolve().name in SPLITS else named


def dataset_id(checksums: Mapping[str, str]) -> str:
    """Return the id of a data set by the SHA-256 of each of its files.

    Parameters
    ----------
    checksums
        Hexadecimal digits by path in the data set, with "/"; what only describes it is left out.

    Examples
    --------
    >>> dataset_id({"a.png": "12", "b.png": "34"}) == dataset_id({"b.png": "34", "README.md": "", "a.png": "12"})
    True
    """
    lines = [f"{checksums[name]}  {name}\n" for name in sorted(checksums, key=str.encode) if name not in DESCRIBING]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def measure_dataset_id(root: Path) -> str:
    """Return the id of a data set as its files are now.

    Raises
    ------
    DatasetError
        If there is no data set, or a file cannot be read.
    """
    try:
        return dataset_id({name: checksum(root / name) for name in content_files(root)})
    except OSError as error:
        raise DatasetError(f"{error.filename}: cannot be read: {error.strerror}") from None


def content_files(root: Path) -> list[str]:
    """List the files that the id of a data set is made of, by their paths in it.

    Raises
    ------
    DatasetError
        If there is no data set.
    """
    folders = split_folders(root)
    if not folders:
        raise DatasetError(f"{root}: not a data set: there is no {METADATA} in it, in train/ or in test/")
    inner = {path.relative_to(root) for folder in folders for path in folder.rglob("*") if path.is_file()}
    seen = [path.as_posix() for path in inner if not any(part.startswith(".") for part in path.parts)]
    return sorted((name for name in seen if name not in DESCRIBING), key=str.encode)


def checksum(path: Path) -> str:
    """Return a file's SHA-256 as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
