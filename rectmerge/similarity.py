"""Similarity of the plane, ``p' = s R(angle) p + t``: rotation, uniform scale and translation, never a reflection."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError


@dataclass(frozen=True, slots=True)
class Similarity:
    """Similarity of the plane, ``p' = scale R(angle) p + (tx, ty)``.

    The same class serves every frame; the variable that holds one says its direction, as in ``b_to_a``.

    Parameters
    ----------
    scale
        Positive, unitless.
    angle
        Radians, from the first axis of the frame towards the second: counter-clockwise in a map frame (y up),
        clockwise to the eye in a pixel frame (v down).
    tx, ty
        Translation, in the units of the target frame.

    Raises
    ------
    InputError
        If the scale is not positive or a number is not finite.

    Examples
    --------
    >>> turn = Similarity(2.0, math.pi / 2, 1.0, 0.0)
    >>> turn.apply([[1.0, 0.0]]).round(6).tolist()
    [[1.0, 2.0]]
    >>> (turn @ turn.inverse()).scale
    1.0
    """

    scale: float = 1.0
    angle: float = 0.0
    tx: float = 0.0
    ty: float = 0.0

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.scale, self.angle, self.tx, self.ty))):
            raise InputError(f"a similarity needs finite numbers, got {self}")
        if self.scale <= 0:
            raise InputError(f"scale must be > 0, got {self.scale}")

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Similarity:
        """Make a similarity from a 2x3 matrix ``[[a, -b, tx], [b, a, ty]]``.

        Raises
        ------
        InputError
            If the matrix is not 2x3 or not a similarity without reflection (to 1e-6 of its scale).
        """
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape != (2, 3):
            raise InputError(f"a similarity matrix has shape (2, 3), got {m.shape}")
        scale = math.hypot(m[0, 0], m[1, 0])
        if not max(abs(m[0, 0] - m[1, 1]), abs(m[0, 1] + m[1, 0])) <= 1e-6 * max(scale, 1e-12):
            raise InputError(f"not a rotation with uniform scale: {m[:, :2].tolist()}")
        return cls(scale, math.atan2(m[1, 0], m[0, 0]), float(m[0, 2]), float(m[1, 2]))

    @classmethod
    def fit(cls, source: ArrayLike, target: ArrayLike) -> Similarity:
        """Fit the similarity that takes `source` points to `target` points with the least squared error.

        Parameters
        ----------
        source, target
            Corresponding points, shape (N, 2), N >= 2, not all equal.

        Raises
        ------
        InputError
            If the shapes differ or the points do not determine a similarity.

        Notes
        -----
        S. Umeyama, PAMI 1991, DOI 10.1109/34.88573. Mirrored points are fitted by the best rotation: det R = +1 always.
        """
        p, q = np.asarray(source, dtype=np.float64), np.asarray(target, dtype=np.float64)
        if p.shape != q.shape or p.ndim != 2 or p.shape[1] != 2 or len(p) < 2:
            raise InputError(f"fit needs two arrays of shape (N, 2) with N >= 2, got {p.shape} and {q.shape}")
        mean_p, mean_q = p.mean(axis=0), q.mean(axis=0)
        dp, dq = p - mean_p, q - mean_q  # (N, 2)
        cos, sin = float((dp * dq).sum()), float((dp[:, 0] * dq[:, 1] - dp[:, 1] * dq[:, 0]).sum())
        spread = float((dp * dp).sum())
        if spread <= 0 or math.hypot(cos, sin) <= 1e-12 * spread:
            raise InputError("the points do not determine a similarity")
        turned = cls(math.hypot(cos, sin) / spread, math.atan2(sin, cos))
        tx, ty = mean_q - turned.apply(mean_p)
        return cls(turned.scale, turned.angle, float(tx), float(ty))

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The 2x3 matrix ``[[a, -b, tx], [b, a, ty]]``."""
        a, b = self.scale * math.cos(self.angle), self.scale * math.sin(self.angle)
        return np.array([[a, -b, self.tx], [b, a, self.ty]]) + 0.0  # no negative zeros

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Map points of shape (..., 2)."""
        m = self.matrix
        mapped: NDArray[np.float64] = np.asarray(points, dtype=np.float64) @ m[:, :2].T + m[:, 2]
        return mapped

    def inverse(self) -> Similarity:
        """Return the similarity that undoes this one."""
        back = Similarity(1.0 / self.scale, -self.angle)
        tx, ty = -back.apply([self.tx, self.ty])
        return Similarity(back.scale, back.angle, float(tx), float(ty))

    def __matmul__(self, first: Similarity) -> Similarity:
        """Compose two similarities: ``(self @ first).apply(p) == self.apply(first.apply(p))``."""
        tx, ty = self.apply([first.tx, first.ty])
        angle = math.remainder(self.angle + first.angle, math.tau)
        return Similarity(self.scale * first.scale, angle, float(tx), float(ty))
