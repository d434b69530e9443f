"""How the cost of every method, and of the stages of `robust`, grows with the size of the maps: one pair, drawn finer.

`rectbench growth` makes a table and a plot of what ``--benchmark-json`` writes.
"""

from __future__ import annotations

import functools

import cv2
import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.analysis.quality import measure_quality
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from rectmerge.methods import available, make_method
from rectmerge.rectangles import maximal_rectangles
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import Params
from tests.bench.bench_paper import noisy_pair
from tests.bench.bench_process import PEAK, run

PARAMS = Params()
SIDES = (400, 1000, 2000, 4000)
ROUNDS = 3
STAGES = {
    "stage: reading the cells": lambda grid: MapCells.from_values(trinary(grid)),
    "stage: quality": measure_quality,
    "stage: maximal rectangles": lambda grid: maximal_rectangles(grid.free),
    "stage: features": lambda grid: extract_features(MapCells.from_values(trinary(grid)), PARAMS.prepare),
}


@functools.cache
def pair_of(side: int) -> tuple[OccupancyGrid, OccupancyGrid]:
    """Draw the noisy pair of the paper's size with other cells: the longest side of both maps has this many."""
    a, b = noisy_pair()
    factor = side / max(*a.shape, *b.shape)
    return resized(a, factor), resized(b, factor)


def resized(grid: OccupancyGrid, factor: float) -> OccupancyGrid:
    cells = cv2.resize(grid.occupancy, None, fx=factor, fy=factor, interpolation=cv2.INTER_NEAREST)
    return OccupancyGrid(np.asarray(cells, np.int8))


@pytest.fixture(autouse=True)
def one_thread():
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    yield
    cv2.setNumThreads(threads)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", available())
def test_method(benchmark, name, side):
    a, b = pair_of(side)
    method = make_method(name)
    benchmark.extra_info |= {"what": name, "side": side}

    alignment = benchmark.pedantic(align, (a, b), {"method": method}, rounds=ROUNDS, warmup_rounds=1)

    benchmark.extra_info |= {"verdict": alignment.verdict}
    assert alignment.method == name


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", STAGES)
def test_stage(benchmark, name, side):
    a, _ = pair_of(side)
    benchmark.extra_info |= {"what": name, "side": side}

    assert benchmark.pedantic(STAGES[name], (a,), rounds=ROUNDS, warmup_rounds=1) is not None


@pytest.mark.parametrize("side", [*SIDES, 8000])
def test_command(benchmark, tmp_path, side):
    for name, grid in zip("ab", pair_of(side), strict=True):
        write_map(grid, tmp_path / f"{name}.yaml")
    words = ["merge", *(str(tmp_path / f"{name}.yaml") for name in "ab"), "-o", str(tmp_path / "out"), "--force", "-q"]
    benchmark.extra_info |= {"what": "rectmerge merge, files and pictures included", "side": side}

    status = benchmark.pedantic(console.run, (cli.app, "rectmerge", words), rounds=ROUNDS, warmup_rounds=1)

    peak = tmp_path / "peak"
    run(["-c", PEAK, *words], statuses=[status], PEAK_FILE=str(peak))
    verdicts = {console.YES: "accepted", console.NO: "rejected", console.AMBIGUOUS: "ambiguous"}
    assert status in verdicts
    benchmark.extra_info |= {"verdict": verdicts[status], "peak_mb": float(peak.read_text())}
