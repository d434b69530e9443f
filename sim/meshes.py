"""Triangle meshes of prisms, for collisions and pictures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim.world import Prism


def build_mesh(prisms: Iterable[Prism]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the sides and tops of prisms as vertices (N, 3) and triangles (M, 3), seen from outside."""
    vertices, triangles, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for prism in prisms:
        n = len(prism.outline)
        vertices += [np.column_stack([prism.outline, np.full(n, z)]) for z in (prism.bottom, prism.top)]
        k = np.arange(n)
        after = (k + 1) % n
        fan = np.column_stack([np.zeros(n - 2, dtype=np.int64), k[1:-1], k[2:]]) + n
        faces = [np.column_stack([k, after, n + after]), np.column_stack([k, n + after, n + k]), fan]
        triangles.append(np.concatenate(faces) + count)
        count += 2 * n
    return np.concatenate(vertices), np.concatenate(triangles)


def build_facets(prisms: Iterable[Prism]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners of the triangles of a mesh, three by three, and the normal at each, both (3 M, 3)."""
    vertices, triangles = build_mesh(prisms)
    corners = vertices[triangles]  # (M, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return corners.reshape(-1, 3), np.repeat(normals, 3, axis=0)


def cut_at_height(prisms: Iterable[Prism], top: float) -> list[Prism]:
    """Return prisms cut at a height, without those that begin above it."""
    return [replace(p, top=min(p.top, top)) for p in prisms if p.bottom < top]
