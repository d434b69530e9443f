"""The size that CONTRIBUTING.md promises of every file."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
FILES = [path for folder in ("rectmerge", "sim", "scenarios", "tests") for path in (ROOT / folder).rglob("*.py")]


def test_no_file_is_longer_than_300_lines():
    lengths = {str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}

    assert {name: length for name, length in lengths.items() if length > 300} == {}
