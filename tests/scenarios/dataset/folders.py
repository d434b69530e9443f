"""Folders of data sets as plain data."""

import json
from pathlib import Path


def contents(folder: Path) -> dict[str, bytes]:
    """Read every file of a folder, by its path in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def rows_of(folder: Path, split: str) -> list[dict]:
    """Read the rows of a split."""
    return [json.loads(line) for line in (folder / split / "metadata.jsonl").read_text().splitlines()]
