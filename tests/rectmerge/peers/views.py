"""What the tests of peers have in common: a rescaled view of the building with its truth, and an unrelated map."""

import numpy as np

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

TRUTH = Similarity(1 / 1.3, 0.7, 75.0, -35.0)  # the view's pixels on the building, all of which it shows


def view() -> OccupancyGrid:
    return drawing.view(drawing.building(), TRUTH, (250, 260))


def unrelated() -> OccupancyGrid:
    """Draw three long halls one beside another."""
    free = np.zeros((120, 150), np.bool_)
    for x, y, w, h in ((5, 5, 30, 110), (38, 5, 60, 50), (101, 5, 44, 110), (35, 20, 3, 10), (98, 20, 3, 10)):
        free[y : y + h, x : x + w] = True
    return drawing.grid_of(free)


def corners_apart(found: Similarity, wanted: Similarity) -> float:
    """Return the largest distance in cells between where two placements put the corners of the building's view."""
    corners = [[40, 40], [220, 40], [40, 210], [220, 210]]
    return float(np.hypot(*(found.apply(corners) - wanted.apply(corners)).T).max())
