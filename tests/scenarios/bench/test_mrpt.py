"""MRPT's aligner as a program, where it was built: its matrix is between pixel centres, B to A."""

import os
from pathlib import Path

import numpy as np
import pytest

from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map
from scenarios.bench.external_program import Program

PROGRAM, MAPS = os.environ.get("RECTMERGE_MRPT"), os.environ.get("RECTMERGE_REAL_MAPS")
SHIFT = (30, 12)  # columns and rows that are cut off B

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(
        not (PROGRAM and MAPS), reason="RECTMERGE_MRPT names no built program, or there are no real maps"
    ),
]


def test_a_part_of_a_map_is_laid_where_it_was_cut():
    a = read_map(Path(MAPS) / "real_lasers" / "test" / "maps" / "edmonton-0.5_a.png")
    b = OccupancyGrid(a.occupancy[SHIFT[1] :, SHIFT[0] :])
    program = Program(command=f"{PROGRAM} {{a}} {{b}} {{scale}}")

    first, again = (program.align(a, b, scale=(1.0, 1.0), rng=np.random.default_rng(0)) for _ in range(2))

    matrix = first.candidates[0].pixels.matrix
    np.testing.assert_allclose(matrix, [[1, 0, SHIFT[0]], [0, 1, SHIFT[1]]], atol=0.1)
    np.testing.assert_array_equal(matrix, again.candidates[0].pixels.matrix)  # the seed is fixed
