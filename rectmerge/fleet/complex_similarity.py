"""Similarity in complex form, ``z -> turn z + shift``: cheap to compose, and linear in its two numbers."""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.similarity import Similarity

Points = NDArray[np.complex128]


class ComplexSimilarity(NamedTuple):
    """Similarity of the plane, ``z -> turn z + shift``, where a point (u, v) is ``z = u + iv``.

    Parameters
    ----------
    turn
        Scale times ``exp(i angle)``.
    shift
        Translation, in the units of the target frame.

    Examples
    --------
    >>> quarter = ComplexSimilarity(2j, 1 + 0j)
    >>> (quarter @ quarter.inverse()).apply(3 + 4j)
    (3+4j)
    """

    turn: complex = 1.0 + 0.0j
    shift: complex = 0.0j

    @classmethod
    def from_similarity(cls, similarity: Similarity) -> ComplexSimilarity:
        """Take the complex form of a similarity."""
        return cls(cmath.rect(similarity.scale, similarity.angle), complex(similarity.tx, similarity.ty))

    def to_similarity(self) -> Similarity:
        """Return the similarity by scale, angle and translation."""
        return Similarity(abs(self.turn), cmath.phase(self.turn), self.shift.real, self.shift.imag)

    @property
    def scale(self) -> float:
        """Units of the target frame per unit of the source."""
        return abs(self.turn)

    def apply(self, points: Points) -> Points:
        """Map points, complex numbers of any shape."""
        return self.turn * points + self.shift

    def inverse(self) -> ComplexSimilarity:
        """Return the similarity that undoes this one."""
        return ComplexSimilarity(1 / self.turn, -self.shift / self.turn)

    def __matmul__(self, first: ComplexSimilarity) -> ComplexSimilarity:
        """Compose two similarities: ``(self @ first).apply(z) == self.apply(first.apply(z))``."""
        return ComplexSimilarity(self.turn * first.turn, self.turn * first.shift + self.shift)


def to_complex(points: ArrayLike) -> Points:
    """Take points (u, v), shape (..., 2), to complex numbers, shape (...)."""
    uv = np.asarray(points, np.float64)
    return uv[..., 0] + 1j * uv[..., 1]


def rms(differences: Points) -> float:
    """Return the root mean square length of some differences."""
    return float(np.sqrt(np.mean(np.abs(differences) ** 2)))
