"""Whole processes, `rectmerge merge a b -o out`: small maps with warm caches, the first run, and 4000 x 4000 cells.

`cpu_s` is the least processor time of the rounds, user and system, children on one thread; the ratios are to what runs
beside it in the same bench: a bare `import numpy, cv2, numba`, or OpenCV reading and writing the same files.
"""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Collection
from pathlib import Path

import cv2
import pytest

from rectmerge.io.map_file import write_map
from tests import drawing
from tests.bench.bench_robust import huge_pair

A, B = (str(drawing.DATA / f"building_{name}.yaml") for name in "ab")
SMALL_CPU_S, FIRST_CPU_S, RATIO_TO_OPENCV, PEAK_MB = 0.8, 12.0, 4.0, 400
IMPORTS = (
    "import rectmerge.cli.main, rectmerge.composing.compose, rectmerge.io.map_file, rectmerge.drawing.maps, "
    "rectmerge.robust.method"
)
BARE = ["-c", "import numpy, cv2, numba"]
MERGE = ["-c", "from rectmerge.cli.main import main; main()", "merge"]
ACTIONS = {"bare-python": ["-c", "pass"], "bare-imports": BARE, "imports-only": ["-c", IMPORTS], "merge": MERGE}
PEAK = r"""
import atexit, os, re, sys
from pathlib import Path
@atexit.register
def note():  # of this process alone: ru_maxrss would keep that of the process which started it
    peak = int(re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())[1]) / 1024
    Path(os.environ["PEAK_FILE"]).write_text(str(peak))
from rectmerge.cli.main import main
main()
"""


def run(words: list[str], *, statuses: Collection[int] = (0,), **environment: str) -> float:
    """Run Python on one thread, to end with one of some statuses; return its processor seconds."""
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, *words], capture_output=True, env=os.environ | one_thread | environment)
    assert done.returncode in statuses, done.stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize("action", ACTIONS)
def test_whole_process(benchmark, tmp_path, action):
    words = [*ACTIONS[action], *([A, B, "--force", "-o", str(tmp_path / "out")] if action == "merge" else [])]
    seconds: list[float] = []

    benchmark.pedantic(lambda: seconds.append(run(words)), rounds=7, warmup_rounds=2)

    assert action != "merge" or (tmp_path / "out" / "merged.yaml").exists()
    bare = min(run(BARE) for _ in range(3))
    benchmark.extra_info |= {"cpu_s": min(seconds), "ratio_to_bare_imports": min(seconds) / bare}
    benchmark.extra_info["aim"] = f"<= {SMALL_CPU_S} s of processor time for the merge"


@pytest.mark.slow
def test_first_merge_on_a_machine(benchmark, tmp_path):
    words, seconds = [*MERGE, A, B, "--force", "-o", str(tmp_path / "out")], []

    def first() -> None:
        seconds.append(run(words, NUMBA_CACHE_DIR=str(tmp_path / f"cache{len(seconds)}")))

    benchmark.pedantic(first, rounds=2)

    assert (tmp_path / "out" / "merged.yaml").exists()
    bare = min(run(BARE) for _ in range(3))
    benchmark.extra_info |= {"cpu_s": min(seconds), "ratio_to_bare_imports": min(seconds) / bare}
    benchmark.extra_info["aim"] = f"<= {FIRST_CPU_S} s of processor time"


@pytest.mark.slow
def test_merge_of_4000_by_4000_images(benchmark, tmp_path):
    images = [tmp_path / "a.png", tmp_path / "b.png"]
    for image, drawn in zip(images, huge_pair(), strict=True):
        write_map(drawn.grid, image.with_suffix(".yaml"), image_suffix=".png")
    peak, seconds = tmp_path / "peak", []
    words = ["-c", PEAK, "merge", *map(str, images), "--force", "-o", str(tmp_path / "out")]

    benchmark.pedantic(lambda: seconds.append(run(words, PEAK_FILE=str(peak))), rounds=3, warmup_rounds=1)

    assert (tmp_path / "out" / "merged.yaml").exists()
    opencv = min(read_and_write(images, tmp_path / "copy.png") for _ in range(3))
    benchmark.extra_info |= {"cpu_s": min(seconds), "opencv_cpu_s": opencv, "ratio_to_opencv": min(seconds) / opencv}
    benchmark.extra_info |= {"peak_mb": float(peak.read_text())}
    benchmark.extra_info["aim"] = f"ratio <= {RATIO_TO_OPENCV:g}, peak <= {PEAK_MB} MB"


def read_and_write(images: list[Path], copy: Path) -> float:
    """Read and write images by OpenCV on one thread; return the processor seconds."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    began = time.process_time()
    for image in images:
        cv2.imwrite(str(copy), cv2.imread(str(image), cv2.IMREAD_UNCHANGED))
    spent = time.process_time() - began
    cv2.setNumThreads(threads)
    return spent


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
