"""Algorithm 2: the R-map, a partition of the free space into maximal empty rectangles with their connections."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.rectangles import Rectangle, run_lengths

Side = Literal["up", "down", "left", "right"]
SIDES: tuple[Side, ...] = ("up", "down", "left", "right")


@dataclass(frozen=True, eq=False)
class RMap:
    """Rectangles of a grid, largest first, with labels and connections.

    Rectangle i of the paper is row i - 1 of `boxes`: labels count from 1, as in the paper.

    Parameters
    ----------
    boxes
        Shape (N, 4), rows (x, y, w, h) in cells.
    labels
        Shape (H, W): the label of the rectangle that holds a cell, 0 for none.
    inclusive_sides
        Whether sides reach one cell too far, as printed in eq. 3.
    """

    boxes: NDArray[np.int32]
    labels: NDArray[np.int32]
    inclusive_sides: bool = False

    def __len__(self) -> int:
        return len(self.boxes)

    @property
    def rectangles(self) -> list[Rectangle]:
        """Rectangles as objects."""
        return [Rectangle(*box) for box in self.boxes.tolist()]

    @property
    def areas(self) -> NDArray[np.int64]:
        """Number of cells of each rectangle, shape (N,)."""
        return self.boxes[:, 2].astype(np.int64) * self.boxes[:, 3]

    def connections(self, label: int, side: Side) -> NDArray[np.int32]:
        """List the labels that touch a side of a rectangle, ascending (eq. 3 and 4)."""
        starts, listed = self._connections
        if not 1 <= label <= len(self):
            raise InputError(f"label must lie in 1..{len(self)}, got {label}")
        at = 4 * (label - 1) + SIDES.index(side)
        return listed[starts[at] : starts[at + 1]]

    @cached_property
    def _connections(self) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        from rectmerge._kernels.neighbours import side_labels

        starts = np.zeros(4 * len(self) + 1, np.int64)
        return starts, side_labels(self.labels, self.boxes, int(self.inclusive_sides), starts)  # Alg. 2, line 7


def rmap(
    free: NDArray[np.bool_],
    *,
    max_rectangles: int | None = None,
    min_area_cells: int = 1,
    inclusive_sides: bool = False,
) -> RMap:
    """Partition the free space into maximal empty rectangles (Algorithm 2).

    Parameters
    ----------
    free
        Mask of free cells (the paper's G), shape (H, W).
    max_rectangles
        Stop after so many; None for all.
    min_area_cells
        Stop where the largest rectangle left is smaller.
    inclusive_sides
        Take eq. 3 as printed: sides one cell too long, so that diagonal neighbours to the lower right count.

    Returns
    -------
    RMap
        Rectangles, labels and connections.

    Raises
    ------
    InputError
        If `free` is not a 2-D mask, or a limit is below its least value.

    Notes
    -----
    The sequence is that of the listing, survey, carve and repeat, with Algorithm 1's order of ties; it is found
    lazily, from bounds that carving can only lower. Departs from the paper: sides are half-open and end at the border.

    Examples
    --------
    >>> found = rmap(np.array([[1, 1, 1], [1, 0, 0]], dtype=bool))
    >>> found.boxes.tolist(), found.connections(1, "down").tolist()
    ([[0, 0, 3, 1], [0, 1, 1, 1]], [2])
    """
    from rectmerge._kernels import rmap as kernels

    if min_area_cells < 1:
        raise InputError(f"min_area_cells must be >= 1, got {min_area_cells}")
    if max_rectangles is not None and max_rectangles < 0:
        raise InputError(f"max_rectangles must be >= 0 or None, got {max_rectangles}")
    runs = run_lengths(free)  # Alg. 2, line 2
    labels = np.zeros(free.shape, np.int32)
    most = free.size if max_rectangles is None else max_rectangles
    boxes = kernels.greedy_rectangles(runs, labels, min_area_cells, most)  # Alg. 2, lines 3-6
    return RMap(boxes, labels, inclusive_sides)
