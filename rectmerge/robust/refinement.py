"""Refinement of placements: on the working grids first, then on the cells of the given maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.fitting import fit_to_fields, fit_to_surfaces, set_equations
from rectmerge._kernels.placements import invert
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.features import Features, by_radius
from rectmerge.robust.params import ExactParams
from rectmerge.similarity import Similarity


def refine(
    placements: NDArray[np.float64],
    a: Features,
    b: Features,
    walls: tuple[NDArray[np.float64], NDArray[np.float64]],
    reaches: tuple[float, ...],
    scale_bounds: tuple[float, float],
) -> NDArray[np.float64]:
    """Move placements to where the walls of each map lie on the walls of the other, shape (N, 4).

    Parameters
    ----------
    placements
        Rows (a, b, tx, ty) between the working grids.
    walls
        The wall points to use of A and of B, shape (N, 2).
    reaches
        Distances, in A's working cells, from which a wall no longer pulls: one Gauss-Newton step each.
    scale_bounds
        Bounds of the scale between the working grids.
    """
    moved = placements.copy()
    fit_to_fields(
        moved, walls[1], a.distance, a.known, walls[0], b.distance, b.known, np.array(reaches), scale_bounds
    )  # fmt: skip
    return moved


def to_pixels(placement: NDArray[np.float64], a: Features, b: Features) -> NDArray[np.float64]:
    """Turn a placement between working grids, (4,), into one between the pixels of the maps."""
    linear = np.array([[placement[0], -placement[1]], [placement[1], placement[0]]])
    shift = (linear @ b.offset + placement[2:] - a.offset) * a.factor
    return np.array([*(placement[:2] * a.factor / b.factor), *shift])


def to_working(pixels: Similarity, a: Features, b: Features) -> NDArray[np.float64]:
    """Undo `to_pixels`: turn a placement between the pixels of the maps into one between working grids, (4,)."""
    linear = pixels.matrix[:, :2] * (b.factor / a.factor)
    shift = pixels.matrix[:, 2] / a.factor + a.offset - linear @ b.offset
    return np.array([linear[0, 0], linear[1, 0], *shift])


@dataclass(frozen=True, eq=False)
class Surface:
    """Wall surface of a map at full resolution.

    Parameters
    ----------
    cells
        Shape (N, 4): (u, v) of each occupied cell beside free space, and the normal into that space.
    index
        Shape (H, W), int32: row in `cells`, -1 elsewhere.
    known
        Shape (H, W): cells that are not unknown.
    """

    cells: NDArray[np.float64]
    index: NDArray[np.int32]
    known: NDArray[np.bool_]

    @classmethod
    def from_cells(cls, cells: MapCells) -> Surface:
        """Take the wall cells that have a normal into free space."""
        faces = cells.normals.any(axis=1)
        surface = np.column_stack([cells.cols[faces], cells.rows[faces], cells.normals[faces]])
        surface = np.ascontiguousarray(surface[by_radius(surface[:, :2])])
        cols, rows = surface[:, :2].astype(np.intp).T
        index = np.full(cells.values.shape, -1, np.int32)
        index[rows, cols] = np.arange(len(rows))
        return cls(surface, index, cells.values >= 0)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least u and v, and greatest, that the cells cover."""
        at = self.cells[:, :2] if len(self.cells) else np.zeros((1, 2))
        return (*(at.min(axis=0) - 0.5).tolist(), *(at.max(axis=0) + 0.5).tolist())

    def seen_by(self, placement: NDArray[np.float64], other: Surface, most: int, looked_at: int) -> NDArray[np.float64]:
        """Return about `most` surface cells that a placement puts within the bounds of another surface.

        They are every so many-th by the distance from the middle. Of the surface, `looked_at` times as many cells are
        tried.
        """
        a, b, tx, ty = placement
        cells = self.cells[:: -(-len(self.cells) // (looked_at * most)) or 1]
        u, v = cells[:, 0], cells[:, 1]
        x, y = a * u - b * v + tx, b * u + a * v + ty
        left, top, right, bottom = other.bounds
        inside = cells[(x >= left) & (y >= top) & (x <= right) & (y <= bottom)]
        spaced: NDArray[np.float64] = inside[:: -(-len(inside) // most) or 1]
        return spaced


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Placement between the pixels of two maps, refined on their cells.

    Parameters
    ----------
    placement
        (a, b, tx, ty) between pixel centres.
    covariance
        Shape (4, 4) over (angle, ln scale, tx, ty) about the centroid of the overlap, in A's pixels.
    surface_matched
        Share of the wall surface on known cells of the other map that lies within two cells of that map's.
    residual_cells
        Root mean square distance of the matched surfaces, in A's cells.
    """

    placement: NDArray[np.float64]
    covariance: NDArray[np.float64]
    surface_matched: float
    residual_cells: float

    @property
    def slack_cells(self) -> float:
        """Standard deviation of the shift in its least certain direction, in A's cells."""
        return math.sqrt(max(0.0, float(np.linalg.eigvalsh(self.covariance[2:, 2:])[-1])))

    def inverse(self) -> Fit:
        """Return the same fit as a placement of A on B."""
        back = invert(self.placement[None])[0]
        turn = -np.eye(4)
        turn[2:, 2:] = [[-back[0], back[1]], [-back[1], -back[0]]]
        scale = math.hypot(back[0], back[1])
        return Fit(back, turn @ self.covariance @ turn.T, self.surface_matched, self.residual_cells * scale)

    def covariance_in_map_frame(self, a: OccupancyGrid) -> NDArray[np.float64]:
        """Return the covariance in A's map frame, where y points up."""
        yaw, cell = a.origin[2], a.cell_size
        turn = np.diag([-1.0, 1.0, 0.0, 0.0])
        turn[2:, 2:] = cell * np.array([[math.cos(yaw), math.sin(yaw)], [math.sin(yaw), -math.cos(yaw)]])
        covariance: NDArray[np.float64] = turn @ self.covariance @ turn.T
        return covariance


def fit_surfaces(
    placement: NDArray[np.float64],
    a: Surface,
    b: Surface,
    scale_bounds: tuple[float, float],
    params: ExactParams,
    *,
    points: int,
) -> Fit:
    """Refine a placement on the maps' own cells: each wall face onto the face with the same normal.

    Thick walls are seen from both sides; matching faces by their normals keeps one side from being pulled onto the
    other. Where too little of the overlap matches (maps that bend against each other), the placement stays, because
    no single similarity is exact there.
    """
    back = invert(placement[None])[0]
    points_b = np.ascontiguousarray(b.seen_by(placement, a, points, params.looked_at))
    points_a = np.ascontiguousarray(a.seen_by(back, b, points, params.looked_at))
    start = tuple(placement.tolist())
    fitted, normal, square, matched, inside = fit_to_surfaces(
        start, points_b, a.index, a.cells, a.known, points_a, b.index, b.cells, b.known,
        np.array(params.reaches_cells), scale_bounds,
        np.array(params.strides), params.min_matched_share / 2,
    )  # fmt: skip
    share = matched / max(1, inside)
    exact = np.array(fitted)
    if share < params.min_matched_share:  # the covariance is measured where the placement stays
        exact = placement
        squares, partners, _ = set_equations(
            normal, np.zeros(4), start, points_b, a.index, a.cells, a.known, points_a, b.index, b.cells, b.known,
            params.reaches_cells[-1], 1,
        )  # fmt: skip
        square = squares / max(1, partners)
    variance = (square + 1 / 12) * params.correlated_cells  # with a cell's own quantisation
    covariance = np.asarray(np.linalg.inv(normal / variance + np.diag(np.array(params.unsure) ** -2)), np.float64)
    covariance = _about_centroid(covariance, exact, points_b)
    return Fit(exact if params.use_fit else placement, covariance, share, math.sqrt(square))


def _about_centroid(
    covariance: NDArray[np.float64], placement: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Move the point that a covariance turns about from B's origin to the centroid of the points of B."""
    u, v = points[:, :2].mean(axis=0) if len(points) else np.zeros(2)
    x, y = placement[0] * u - placement[1] * v, placement[1] * u + placement[0] * v
    about = np.eye(4)
    about[2, :2] = -y, x
    about[3, :2] = x, y
    moved: NDArray[np.float64] = about @ covariance @ about.T
    return moved
