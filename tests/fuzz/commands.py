"""Commands as people run them, for tests that only ask that nothing breaks."""

from __future__ import annotations

import shutil
from pathlib import Path

import rectmerge as rm
from rectmerge.cli import console
from rectmerge.cli import main as cli
from tests.fuzz.grids import Cells

ANSWERS = {console.YES, console.NO, console.AMBIGUOUS}
ANSWERED = ANSWERS | {console.BAD_INPUT}


def run(*words: object) -> int:
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


def save(folder: Path, name: str, cells: Cells, **frame: object) -> Path:
    """Write cells as a map, whatever they are."""
    path = folder / f"{name}.yaml"
    rm.write_map(rm.OccupancyGrid(cells, **frame), path)  # type: ignore[arg-type]
    return path


def merged_or_refused(capsys, folder: Path, a: Path, b: Path, *words: object) -> int:
    """Merge two files; assert a verdict with its whole folder, or one clear line and nothing written."""
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    status = run("merge", a, b, "-o", out, *words)
    said = capsys.readouterr()
    assert "Traceback" not in said.err + said.out
    left = sorted(path.name for path in out.iterdir()) if out.exists() else []
    if status == console.BAD_INPUT:
        assert left == []
        assert len(said.err.strip().splitlines()) == 1, said.err
    else:
        assert status in ANSWERS, said.err
        assert "alignment.json" in left
        assert ("merged.yaml" in left) == (status == console.YES)
        assert not [name for name in left if name.endswith(".part")]
    return status
