"""Warp between the pixels of two maps: a similarity, then a displacement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.elastic.lattice import Displacement
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, eq=False)
class Warp:
    """Warp T(p) = S p + u(S p) from B's pixels to A's.

    Parameters
    ----------
    similarity
        S, from B's pixels to A's.
    displacement
        u, in A's pixels.
    """

    similarity: Similarity
    displacement: Displacement

    def apply(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Take B's pixel points, (..., 2), to A's."""
        return self.displacement.apply(self.similarity.apply(pixels))

    def undo(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Take A's pixel points, (..., 2), to B's; exact where nothing is folded."""
        return self.similarity.inverse().apply(self.displacement.undo(pixels))

    def jacobian(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the derivative of `apply` at B's pixel points, (..., 2, 2)."""
        linear = self.similarity.matrix[:, :2]
        jacobian: NDArray[np.float64] = self.displacement.jacobian(self.similarity.apply(pixels)) @ linear
        return jacobian

    def contains(self, pixels: ArrayLike) -> NDArray[np.bool_]:
        """Return whether B's pixel points, (..., 2), lie in the lattice; beyond it the displacement is its edge's."""
        return self.displacement.lattice.contains(self.similarity.apply(pixels))
