"""Pairs per minute of a whole run, simulation and start-up included, by one worker, two, and a dask cluster of two.

`efficiency` is the rate over that of one worker times the number of workers; `bytes_per_pair` is what is kept of a
pair: its maps, its row in the data set, its share of the buildings, and the rows of its results.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

SUITE, PAIRS = "sweep-noise", 96
AIM_EFFICIENCY = 0.85
RATES: dict[str, float] = {}  # pairs per minute, in the order in which the benches run


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
def test_scaling(benchmark, how, tmp_path):
    pytest.importorskip("pybullet")
    rectbench = [str(Path(sys.executable).with_name("rectbench")), "run", SUITE, "--method", "robust", "-q"]

    with workers(how) as options:
        command = [*rectbench, "-o", str(tmp_path / "run"), *options]
        benchmark.pedantic(subprocess.run, (command,), {"check": True, "capture_output": True}, rounds=1)

    assert len((tmp_path / "run" / "results.jsonl").read_text().splitlines()) == PAIRS
    RATES[how] = 60 * PAIRS / benchmark.stats.stats.min
    size = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*") if path.is_file())
    benchmark.extra_info |= {"pairs_per_minute": RATES[how], "bytes_per_pair": size // PAIRS}
    if how != "1" and "1" in RATES:
        benchmark.extra_info |= {"efficiency": RATES[how] / (2 * RATES["1"]), "aim": f"efficiency >= {AIM_EFFICIENCY}"}
