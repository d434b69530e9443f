"""Transform between map frames that bends: a similarity, then a displacement on a lattice in A's map frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.elastic.lattice import Displacement, Lattice
from rectmerge.elastic.warp import Warp
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity

SCHEMA = "rectmerge.bend/1"
CELL_DECIMALS = 3  # of a cell of A, in files
MAX_NODES = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class BentTransform:
    """Transform T(p) = x + u(x), x = b_to_a(p), from B's map frame to A's.

    Parameters
    ----------
    b_to_a
        The similarity.
    origin
        Where the lattice begins, in A's map frame: the corner of its box, one spacing after the first node.
    axes
        Shape (2, 2): columns from a node to the next along the lattice's two axes, in A's map frame.
    displacement
        u with a lattice of spacing 1 that begins at (0, 0), in its units.
    std_at_nodes
        Shape (nodes,): standard deviation at the nodes, in A's map units, in the order of `Lattice.steps`.
    cell_size
        Map units per cell of A, for the precision of files.
    unit
        Unit of A's map frame, "m" or "cells".
    """

    b_to_a: Similarity
    origin: NDArray[np.float64]
    axes: NDArray[np.float64]
    displacement: Displacement
    std_at_nodes: NDArray[np.float64]
    cell_size: float
    unit: str

    @classmethod
    def from_pixels(
        cls, b_to_a: Similarity, displacement: Displacement, std_cells: NDArray[np.float64], a: OccupancyGrid
    ) -> BentTransform:
        """Take a displacement in A's pixels, and its standard deviation at the nodes in cells of A."""
        grid = displacement.lattice
        steps = np.array([[0.0, 0.0], [grid.spacing, 0.0], [0.0, grid.spacing]])
        origin, *ends = a.pixel_to_map(steps + grid.corner)
        axes = np.stack([end - origin for end in ends], axis=1)
        unit_lattice = Lattice((0.0, 0.0), 1.0, grid.counts)
        scaled = Displacement(unit_lattice, displacement.coefficients / grid.spacing)
        return cls(b_to_a, origin, axes, scaled, std_cells * a.cell_size, a.cell_size, a.unit)

    def between_pixels(self, a: OccupancyGrid, b: OccupancyGrid) -> Warp:
        """Return the transform from B's pixels to A's; the lattice lies along A's pixels."""
        corner, spacing = a.map_to_pixel(self.origin), float(np.linalg.norm(self.axes[:, 0])) / a.cell_size
        unit = self.displacement
        lattice = Lattice((float(corner[0]), float(corner[1])), spacing, unit.lattice.counts)
        return Warp(map_frame_to_pixels(self.b_to_a, a, b), Displacement(lattice, unit.coefficients * spacing))

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points of B's map frame, (..., 2), to A's."""
        return self._from_lattice(self.displacement.apply(self._to_lattice(self.b_to_a.apply(points))))

    def inverse(self) -> InverseTransform:
        """Return the transform from A's map frame to B's."""
        return InverseTransform(self)

    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the derivative of `apply` at points of B's map frame, (..., 2, 2)."""
        inner = self.displacement.jacobian(self._to_lattice(self.b_to_a.apply(points)))
        jacobian: NDArray[np.float64] = self.axes @ inner @ np.linalg.inv(self.axes) @ self.b_to_a.matrix[:, :2]
        return jacobian

    def local_angle(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the turn from B's map frame to A's at points of B's, (...): radians, counter-clockwise."""
        j = self.jacobian(points)
        angle: NDArray[np.float64] = np.arctan2(j[..., 1, 0] - j[..., 0, 1], j[..., 0, 0] + j[..., 1, 1])
        return angle

    def similarity_at(self, point: ArrayLike) -> Similarity:
        """Return the similarity that is right near one point of B's map frame, (2,): its place, turn and scale."""
        scale = math.sqrt(float(np.linalg.det(self.jacobian(point))))
        angle = float(self.local_angle(point))
        tx, ty = self.apply(point) - Similarity(scale, angle).apply(point)
        return Similarity(scale, angle, float(tx), float(ty))

    def std(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the standard deviation of the displaced points of B's map frame, (...), in A's map units."""
        spread = Displacement(self.displacement.lattice, np.repeat(self.std_at_nodes[:, np.newaxis], 2, axis=1))
        std: NDArray[np.float64] = spread.at(self._to_lattice(self.b_to_a.apply(points)))[..., 0]
        return std

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points of B's map frame, (..., 2), lie in the lattice; beyond it u is that of its edge."""
        return self.displacement.lattice.contains(self._to_lattice(self.b_to_a.apply(points)))

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the content of ``unbend.json``."""
        lattice, decimals = self.displacement.lattice, CELL_DECIMALS - math.floor(math.log10(self.cell_size))
        moves = self.displacement.coefficients @ self.axes.T
        return {
            "schema": SCHEMA,
            "unit": self.unit,
            "cell_size": self.cell_size,
            "b_to_a": {
                "scale": self.b_to_a.scale,
                "angle_rad": self.b_to_a.angle,
                "translation": [self.b_to_a.tx, self.b_to_a.ty],
            },
            "lattice": {
                "splines": "uniform cubic",
                "origin": self.origin.tolist(),
                "axis_1": self.axes[:, 0].tolist(),
                "axis_2": self.axes[:, 1].tolist(),
                "first_node": [-1, -1],
                "x": lattice.as_rows(moves[:, 0]).round(decimals).tolist(),
                "y": lattice.as_rows(moves[:, 1]).round(decimals).tolist(),
                "std": lattice.as_rows(self.std_at_nodes).round(decimals).tolist(),
            },
        }

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> BentTransform:
        """Read what `as_dict` returns.

        Raises
        ------
        KeyError, TypeError, ValueError
            If it is something else, a number is not finite, or the lattice is none.
        """
        if record["schema"] != SCHEMA:
            raise ValueError(f"no schema {record['schema']!r}")
        entry, placed = record["lattice"], record["b_to_a"]
        rows = [np.array(entry[name], np.float64) for name in ("x", "y", "std")]
        axes = np.array([entry["axis_1"], entry["axis_2"]], np.float64).T
        origin = np.array(entry["origin"], np.float64)
        shapes = {row.shape for row in rows}
        if len(shapes) != 1 or rows[0].ndim != 2 or min(rows[0].shape) < 4 or rows[0].size > MAX_NODES:
            raise ValueError("the lattice must have x, y and std of one shape, 4 x 4 nodes or more")
        if axes.shape != (2, 2) or origin.shape != (2,) or not all(np.isfinite(v).all() for v in (*rows, axes, origin)):
            raise ValueError("the lattice must have finite numbers")
        lattice = Lattice((0.0, 0.0), 1.0, (rows[0].shape[1], rows[0].shape[0]))
        moves = np.stack([lattice.from_rows(row) for row in rows[:2]], axis=1)
        return cls(
            Similarity(placed["scale"], placed["angle_rad"], *placed["translation"]),
            origin,
            axes,
            Displacement(lattice, moves @ np.linalg.inv(axes).T),
            lattice.from_rows(rows[2]),
            float(record["cell_size"]),
            str(record["unit"]),
        )

    def _to_lattice(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        places: NDArray[np.float64] = (points - self.origin) @ np.linalg.inv(self.axes).T
        return places

    def _from_lattice(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        points: NDArray[np.float64] = places @ self.axes.T + self.origin
        return points


@dataclass(frozen=True, slots=True, eq=False)
class InverseTransform:
    """Transform from A's map frame to B's.

    Parameters
    ----------
    forward
        The transform from B to A.
    """

    forward: BentTransform

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points of A's map frame, (..., 2), to B's; exact where nothing is folded."""
        bent = self.forward
        places = bent._to_lattice(np.asarray(points, np.float64))
        return bent.b_to_a.inverse().apply(bent._from_lattice(bent.displacement.undo(places)))
