"""The whole of `merge` on maps that no robot would draw: a verdict or one line, within 30 seconds."""

import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

import rectmerge as rm
from rectmerge.aligning import align
from rectmerge.cli import console
from rectmerge.methods import available
from tests.fuzz import grids
from tests.fuzz.commands import ANSWERED, merged_or_refused, run, save
from tests.marking import some_slow

LONGEST_S = 30.0  # what nobody should wait for without an answer; the machines of these tests are slow and busy
FEW = settings.default.max_examples // 10  # a whole merge takes its time
FRAMES = {
    "tiny cells": {"resolution": 1e-9},
    "hardly any cells": {"resolution": 1e-300},
    "huge cells": {"resolution": 1e9},
    "enormous cells": {"resolution": 1e300},
    "far away": {"resolution": 0.05, "origin": (4e9, -4e9, 0.0)},
    "beyond all numbers": {"resolution": 0.05, "origin": (1e300, -1e300, 0.0)},
    "wound up": {"resolution": 0.05, "origin": (0.0, 0.0, 1e9)},
}

SCALES = ["1e-300", "1e300", "1e-9", "0.0001", "10000", "0.0001:10000", "1e-5:1e5"]


@pytest.mark.parametrize("name", some_slow(grids.ADVERSARIES, "one free cell"))
def test_hostile_maps_have_an_answer(tmp_path, capsys, name):
    cells = grids.ADVERSARIES[name](150)
    a, b = save(tmp_path, "a", cells), save(tmp_path, "b", np.rot90(cells).copy())

    assert merged_or_refused(capsys, tmp_path, a, b) in ANSWERED


@pytest.mark.slow
@pytest.mark.parametrize("name", ["checkerboard", "room", "noise", "lattice"])
def test_what_looks_the_same_everywhere_is_not_merged(tmp_path, capsys, name):
    cells = grids.ADVERSARIES[name](200)
    other = grids.noise(200, seed=1) if name == "noise" else cells
    a, b = save(tmp_path, "a", cells), save(tmp_path, "b", other)

    assert merged_or_refused(capsys, tmp_path, a, b) != console.YES


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_ribbons_have_an_answer(tmp_path, capsys, rows):
    a, b = save(tmp_path, "a", grids.ribbon(rows)), save(tmp_path, "b", grids.ribbon(max(2, rows))[:, ::-1].copy())

    status = merged_or_refused(capsys, tmp_path, a, b)

    assert (status == console.BAD_INPUT) == (rows == 1)  # a single row is no map


@pytest.mark.parametrize("name", some_slow(FRAMES, "far away"))
def test_strange_frames_have_an_answer(tmp_path, capsys, name):
    cells = grids.noise(60, 0.1, 0.1)
    a, b = save(tmp_path, "a", cells, **FRAMES[name]), save(tmp_path, "b", cells, resolution=0.05)

    assert merged_or_refused(capsys, tmp_path, a, b) in ANSWERED
    assert merged_or_refused(capsys, tmp_path, b, a) in ANSWERED


@pytest.mark.parametrize("scale", some_slow(SCALES, "1e-300", "1e300"))
def test_strange_scales_have_an_answer(tmp_path, capsys, scale):
    a, b = save(tmp_path, "a", grids.room(60)), save(tmp_path, "b", grids.room(50))

    assert merged_or_refused(capsys, tmp_path, a, b, "--scale", scale) in ANSWERED


@pytest.mark.slow
def test_maps_of_very_different_sizes_have_an_answer(tmp_path, capsys):
    a, b = save(tmp_path, "a", grids.room(1500)), save(tmp_path, "b", grids.room(5))

    assert merged_or_refused(capsys, tmp_path, a, b) in ANSWERED
    assert merged_or_refused(capsys, tmp_path, b, a) in ANSWERED


CELLS = arrays(
    np.int8,
    array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=24),
    elements=st.sampled_from([-1, 0, 0, 50, 100]),
)


@settings(max_examples=FEW, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(one=CELLS, other=CELLS, scale=st.sampled_from(["auto", "free", "1", "0.1:10"]))
def test_random_maps_have_an_answer(tmp_path, capsys, one, other, scale):
    a, b = save(tmp_path, "a", one), save(tmp_path, "b", other)

    assert merged_or_refused(capsys, tmp_path, a, b, "--scale", scale) in ANSWERED


@settings(max_examples=FEW, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cells=CELLS, numbers=st.tuples(*[st.floats(-1e12, 1e12) for _ in range(4)]))
def test_random_placements_have_an_answer(tmp_path, capsys, cells, numbers):
    a, b = save(tmp_path, "a", grids.room(30)), save(tmp_path, "b", cells)
    pixels = ",".join(map(str, numbers))

    assert merged_or_refused(capsys, tmp_path, a, b, f"--pixels={pixels}") in ANSWERED
    assert merged_or_refused(capsys, tmp_path, a, b, "--guess", ",".join(map(str, numbers[:3]))) in ANSWERED
    assert run("check", a, b, f"--pixels={pixels}") in ANSWERED
    capsys.readouterr()


@pytest.mark.parametrize("method", available())
@pytest.mark.parametrize(
    "name", some_slow(["checkerboard", "spiral", "one free cell", "all free", "dust"], "one free cell")
)
def test_every_method_has_an_answer(method, name):
    cells = grids.ADVERSARIES[name](40)

    alignment = align(rm.OccupancyGrid(cells), rm.OccupancyGrid(np.rot90(cells)[:30].copy()), method=method)

    assert alignment.verdict in ("accepted", "ambiguous", "rejected")
    assert alignment.reason


@pytest.mark.slow
@pytest.mark.parametrize("method", available())
@pytest.mark.parametrize("name", ["spiral", "noise", "lattice"])
def test_large_hostile_maps_keep_nobody_waiting(method, name):
    cells = grids.ADVERSARIES[name](600)
    a, b = rm.OccupancyGrid(cells), rm.OccupancyGrid(np.rot90(grids.ADVERSARIES[name](420)).copy())
    started = time.process_time()

    assert align(a, b, method=method).reason
    assert time.process_time() - started < LONGEST_S


@pytest.mark.slow
@pytest.mark.parametrize("name", ["comb", "dust"])
def test_larger_ones_are_answered_by_the_default_method(name):
    grid = rm.OccupancyGrid(grids.ADVERSARIES[name](1600))
    started = time.process_time()

    assert align(grid, grid).reason
    assert time.process_time() - started < LONGEST_S
