import numpy as np
import pytest

from rectmerge.analysis.shared_area import measure_shared_area
from rectmerge.grid import pixels_to_map_frame
from rectmerge.similarity import Similarity
from tests import drawing


def test_the_shared_area_is_what_both_maps_show():
    a = drawing.building(resolution=0.05)
    pixels = Similarity(1.0, 0.0, 80.0, 0.0)  # the right half of A is the left part of B
    b = drawing.view(a, pixels, (113, 163), resolution=0.05)

    shared = measure_shared_area(a, b, pixels)

    free = np.argwhere(a.free & (np.arange(163) >= 80))[:, ::-1]
    expected = a.pixel_to_map(free).mean(axis=0)
    assert pixels_to_map_frame(pixels, a, b).apply(shared.centre) == pytest.approx(expected, abs=0.05)
