import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from sim.importers.grids import MOST_WALLS, world_from_grid
from tests.sim import naive

CELLS = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.sampled_from([-1, 0, 0, 100]))


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(CELLS, st.sampled_from([0.34, 0.5, 1.0]), st.sampled_from([0.0, 1.0, 1.7]))
def test_the_raster_of_a_map_is_the_map_with_its_open_ends_walled_off(cells, resolution, narrowest_m):
    narrowest_cells = 1 + 2 * int(narrowest_m / resolution / 2)
    padded = np.pad(cells, 1, constant_values=-1)
    known = {cell for cell in np.ndindex(padded.shape) if padded[cell] >= 0}
    assume(any(naive.is_wide(cell, known, narrowest_cells) for cell in known if padded[cell] == 0))

    world = world_from_grid(OccupancyGrid(cells, resolution), "made", narrowest_m=narrowest_m)

    assert np.array_equal(world.raster(resolution).occupancy, naive.walled_off(cells, narrowest_cells))


def test_a_map_of_too_many_walls_is_refused_rather_than_left_to_the_engine():
    cells = np.indices((400, 200)).sum(axis=0) % 2 * 100

    with pytest.raises(InputError, match=f"more than {MOST_WALLS}"):
        world_from_grid(OccupancyGrid(cells.astype(np.int8), 0.1), "chess")
