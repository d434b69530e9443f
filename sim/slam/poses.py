"""Algebra of planar poses (x, y, yaw): relative, composed and chained poses, and angles in -pi..pi."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def chain_poses(start: NDArray[np.float64], steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Chain steps (N, 3), each in the frame of the pose before it, from a pose (3,); return poses (N+1, 3)."""
    yaw = start[2] + np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    cos, sin = np.cos(yaw[:-1]), np.sin(yaw[:-1])
    x = start[0] + np.concatenate([[0.0], np.cumsum(cos * steps[:, 0] - sin * steps[:, 1])])
    y = start[1] + np.concatenate([[0.0], np.cumsum(sin * steps[:, 0] + cos * steps[:, 1])])
    return np.stack([x, y, wrap_angles(yaw)], axis=-1)


def relative_poses(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return poses (..., 3) `second` in the frame of poses `first`."""
    d = second - first
    cos, sin = np.cos(first[..., 2]), np.sin(first[..., 2])
    x, y = cos * d[..., 0] + sin * d[..., 1], cos * d[..., 1] - sin * d[..., 0]
    return np.stack([x, y, wrap_angles(d[..., 2])], axis=-1)


def compose_poses(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return poses (..., 3) `second`, given in the frame of poses `first`, in the frame of `first` itself."""
    cos, sin = np.cos(first[..., 2]), np.sin(first[..., 2])
    x = first[..., 0] + cos * second[..., 0] - sin * second[..., 1]
    y = first[..., 1] + sin * second[..., 0] + cos * second[..., 1]
    return np.stack([x, y, wrap_angles(first[..., 2] + second[..., 2])], axis=-1)


def wrap_angles(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return angles in -pi..pi."""
    turned: NDArray[np.float64] = np.arctan2(np.sin(angle), np.cos(angle))
    return turned
