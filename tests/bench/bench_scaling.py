"""Pairs per minute of a whole run, simulation and start-up included, by one worker, two, and a dask cluster of two.

`efficiency` is the rate over that of one worker times the number of workers. What the machine itself allows stands
beside it: `machine`, the same work without any runner, alone over twice at once; below 1 where cores share something.
`load` is what else ran in the minute before. `bytes_per_pair` is what is kept of a pair: its maps, its row in the data
set, its share of the buildings, and the rows of its results.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from scenarios.suites.suite import SUITES

SUITE, MISSIONS, PAIRS_EACH = "sweep-noise", 96, 4  # minutes, so that the start of workers does not count
AIM_EFFICIENCY = 0.85
LOOP = "sum(i * i % 7 for i in range(30_000_000))"
RATES: dict[str, float] = {}  # pairs per minute, in the order in which the benches run


@pytest.fixture(scope="module")
def suite(tmp_path_factory) -> Path:
    """Write the suite with more missions."""
    said = (SUITES / f"{SUITE}.toml").read_text()
    file = tmp_path_factory.mktemp("suite") / f"{SUITE}.toml"
    file.write_text(said.replace("count = 24", f"count = {MISSIONS}"))
    return file


@pytest.fixture(scope="module")
def machine() -> float:
    """Time a loop alone, and twice at once."""
    alone, together = (_seconds(count) for count in (1, 2))
    return alone / together


def _seconds(count: int) -> float:
    began = time.perf_counter()
    for process in [subprocess.Popen([sys.executable, "-c", LOOP]) for _ in range(count)]:
        assert process.wait() == 0
    return time.perf_counter() - began


@contextmanager
def workers(how: str) -> Iterator[list[str]]:
    """Give the options of `rectbench run` for a way of working; a cluster lives as long as the body."""
    if how != "dask":
        yield ["--workers", how]
        return
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        yield ["--cluster", cluster.scheduler_address]


@pytest.mark.parametrize("how", ["1", "2", "dask"])
def test_scaling(benchmark, how, tmp_path, suite, machine):
    pytest.importorskip("pybullet")
    rectbench, pairs = Path(sys.executable).with_name("rectbench"), MISSIONS * PAIRS_EACH
    load = os.getloadavg()[0]

    with workers(how) as options:
        command = [str(rectbench), "run", str(suite), "--method", "robust", "-q", "-o", str(tmp_path / "run"), *options]
        benchmark.pedantic(subprocess.run, (command,), {"check": True, "capture_output": True}, rounds=1)

    assert len((tmp_path / "run" / "results.jsonl").read_text().splitlines()) == pairs
    RATES[how] = 60 * pairs / benchmark.stats.stats.min
    size = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*") if path.is_file())
    benchmark.extra_info |= {"pairs_per_minute": RATES[how], "bytes_per_pair": size // pairs, "load": load}
    if how != "1" and "1" in RATES:
        efficiency = RATES[how] / (2 * RATES["1"])
        benchmark.extra_info |= {"efficiency": efficiency, "machine": machine, "aim": f"efficiency >= {AIM_EFFICIENCY}"}
