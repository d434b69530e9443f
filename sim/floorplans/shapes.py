"""Outlines as arrays of corners: rectangles, discs, and offsets of their sides."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]


def counter_clockwise(corners: ArrayLike) -> Points:
    """Return corners (N, 2) in counter-clockwise order."""
    outline = np.array(corners, dtype=np.float64)
    x, y = outline.T
    return outline if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0 else outline[::-1].copy()


def rectangle(left: float, low: float, right: float, high: float) -> Points:
    """Return the corners (4, 2) of an upright rectangle, counter-clockwise."""
    return np.array([[left, low], [right, low], [right, high], [left, high]], dtype=np.float64)


def disc(centre: ArrayLike, radius: float, corners: int) -> Points:
    """Return a regular polygon (corners, 2), counter-clockwise."""
    angle = (np.arange(corners) + 0.5) * (2 * np.pi / corners)
    around: Points = np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return around


def offset(corners: Points, inward: float) -> Points:
    """Move the sides of a counter-clockwise outline inward, with mitred corners."""
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=-1) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
    before = np.roll(normals, 1, axis=0)
    mitre = (normals + before) / (1.0 + np.sum(normals * before, axis=1))[:, None]
    moved: Points = corners + inward * mitre
    return moved
