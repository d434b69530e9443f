"""One whole process, `rectmerge merge a b -o out`, caches warm, and what of it is imports."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests import drawing

A, B = (str(drawing.DATA / f"building_{name}.yaml") for name in "ab")
WHOLE_S = 1.5
IMPORTS = (
    "import rectmerge.cli.main, rectmerge.composing.compose, rectmerge.io.map_file, rectmerge.drawing.maps, "
    "rectmerge.robust.method"
)
ACTIONS = {
    "bare-python": ["-c", "pass"],
    "imports-only": ["-c", IMPORTS],
    "merge": ["-c", "from rectmerge.cli.main import main; main()", "merge", A, B, "--force", "-o"],
}


@pytest.mark.parametrize("action", ACTIONS)
def test_whole_process(benchmark, tmp_path, action):
    command = [sys.executable, *ACTIONS[action], *([str(tmp_path / "out")] if action == "merge" else [])]

    def run() -> None:
        subprocess.run(command, check=True, capture_output=True)

    benchmark.pedantic(run, rounds=7, warmup_rounds=2)

    assert action != "merge" or (tmp_path / "out" / "merged.yaml").exists()
    benchmark.extra_info["aim"] = f"<= {WHOLE_S} s for the merge"


def test_slowest_imports(benchmark):
    """Where the imports go: the packages with the most time of their own, milliseconds."""
    command = [sys.executable, "-X", "importtime", "-c", IMPORTS]
    import_times = benchmark.pedantic(
        lambda: subprocess.run(command, check=True, capture_output=True, text=True).stderr, rounds=3, warmup_rounds=1
    )
    own: dict[str, float] = {}
    for match in re.finditer(r"import time:\s+(\d+) \|\s+\d+ \|\s+([\w.]+)", import_times):
        package = match[2].split(".")[0]
        own[package] = own.get(package, 0.0) + int(match[1]) / 1000
    benchmark.extra_info |= dict(sorted(own.items(), key=lambda each: -each[1])[:8])

    assert "numba" in own
