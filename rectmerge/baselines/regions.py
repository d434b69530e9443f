"""Baseline `regions`: bounding boxes of free regions, matched in four rolls, clustered and scored by association."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.analysis.downscaling import Shrunk, between_given, shrunk_bounds
from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.baselines.ranked_answer import MAX_CANDIDATES, Placement, answer
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

LEVELS = (0.15, 0.25, 0.35, 0.5, 0.7)  # thresholds of the distance to walls that cut regions, shares of the largest
LEAST_SIDE_CELLS = 4.0
MAX_HYPOTHESES = 3000  # those whose boxes fit best are clustered
Boxes = NDArray[np.complex128]  # (N, 4): corners u + iv, in turn


@dataclass(frozen=True, slots=True, kw_only=True)
class Regions:
    """Align by oriented bounding boxes of free regions, matched in four rolls and clustered.

    Parameters
    ----------
    side_cells
        The longest side of the images that regions are found in, in cells.
    max_regions
        Regions taken of each map, the largest.
    shape_tolerance
        Largest distance of a box's corners from those of the box it is laid on, as a share of its size.
    cluster_deg, cluster_scale, cluster_shift
        Hypotheses this close to each other share a cluster: degrees, ln scale, and shares of the extent of A.
    associated_within
        Boxes associate if their centres are this close, as a share of their size, and their sizes differ by no more.
    accept_at
        The least association score that is accepted.

    Raises
    ------
    InputError
        If a count is below 1, a tolerance not above 0, or `accept_at` outside (0, 1].

    Notes
    -----
    S. G. Shahbandi and M. Magnusson, "2D map alignment with region decomposition", Autonomous Robots 43, 2019,
    DOI 10.1007/s10514-018-9785-7: regions' oriented minimum bounding boxes are laid on each other in all four rolls,
    each giving a hypothesis; these are clustered, and the cluster under which most regions associate wins. The scale is
    unknown there, too: nothing was added but its bounds. This is written from the outline of the method, not from its
    details: regions are what is left of the free space at several distances from walls, a box is laid on another by
    least squares, and association, clusters and all parameters are ours. Not compared with the authors' program.
    """

    name: ClassVar[str] = "regions"
    side_cells: int = 300
    max_regions: int = 60
    shape_tolerance: float = 0.08
    cluster_deg: float = 4.0
    cluster_scale: float = 0.06
    cluster_shift: float = 0.03
    associated_within: float = 0.15
    accept_at: float = 0.5

    def __post_init__(self) -> None:
        for field in ("side_cells", "max_regions"):
            if getattr(self, field) < 1:
                raise InputError(f"{field} must be >= 1, got {getattr(self, field)}")
        for field in ("shape_tolerance", "cluster_deg", "cluster_scale", "cluster_shift", "associated_within"):
            if not getattr(self, field) > 0:
                raise InputError(f"{field} must be > 0, got {getattr(self, field)}")
        if not 0 < self.accept_at <= 1:
            raise InputError(f"accept_at must be in (0, 1], got {self.accept_at}")

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        shrunk = Shrunk.from_grid(a, self.side_cells), Shrunk.from_grid(b, self.side_cells)
        boxes = [region_boxes(each.grid, self.max_regions) for each in shrunk]
        for name, regions in zip("AB", boxes, strict=True):
            if len(regions) == 0:
                return Alignment(verdict="rejected", reason=f"map {name} has no region", method=self.name)
        turns, shifts = self._hypotheses(boxes[0], boxes[1], shrunk_bounds(scale, *shrunk))
        placements = []
        for turn, shift in self._clusters(turns, shifts, boxes):
            pixels = Similarity(abs(turn), float(np.angle(turn)), float(shift.real), float(shift.imag))
            score = self._association(boxes[0], turn * boxes[1] + shift)
            placements.append(Placement(between_given(pixels, *shrunk), score))
        nothing = "no region of one map has the shape of one of the other at a scale within bounds"
        return answer(self.name, a, b, placements, accept_at=self.accept_at, scale=scale, nothing=nothing)

    def _hypotheses(self, a: Boxes, b: Boxes, bounds: tuple[float, float]) -> tuple[Boxes, Boxes]:
        """Lay every box of B on every box of A in four rolls; return turns with scale, and shifts, best first, (M,)."""
        middle_a, middle_b = a.mean(axis=1), b.mean(axis=1)
        around_a, around_b = a - middle_a[:, None], b - middle_b[:, None]
        rolled = np.stack([np.roll(around_a, roll, axis=1) for roll in range(4)], axis=1)  # (A, 4, corners)
        power = (np.abs(around_b) ** 2).sum(axis=1)
        turns = np.einsum("ark,bk->abr", rolled, around_b.conj()) / power[:, None]
        misses = np.abs(rolled[:, None] - turns[..., None] * around_b[:, None]).max(axis=3)  # (A, B, 4)
        size = np.abs(around_a).max(axis=1)[:, None, None]
        scales = np.abs(turns)
        lo, hi = bounds[0] * (1 - 1e-9), bounds[1] * (1 + 1e-9)
        if bounds[1] / bounds[0] < 1 + self.cluster_scale:  # a scale that is known: boxes only have to come near it
            known = math.sqrt(bounds[0] * bounds[1])
            near = np.abs(np.log(scales / known)) < self.cluster_scale
            turns = np.where(near, turns / scales * known, turns)
        kept = np.argwhere((misses / size < self.shape_tolerance) & (np.abs(turns) >= lo) & (np.abs(turns) <= hi))
        order = np.argsort((misses / size)[tuple(kept.T)], kind="stable")[:MAX_HYPOTHESES]
        i, j, roll = kept[order].T
        best_turns = turns[i, j, roll]
        return best_turns, middle_a[i] - best_turns * middle_b[j]

    def _clusters(self, turns: Boxes, shifts: Boxes, boxes: list[Boxes]) -> list[tuple[np.complex128, np.complex128]]:
        """Cluster like hypotheses; return the means (turn, shift) of the largest clusters."""
        middle, extent = boxes[1].mean(), np.ptp(boxes[0].real) + np.ptp(boxes[0].imag)
        at = np.stack([np.angle(turns), np.log(np.abs(turns))], axis=1)
        centres = turns * middle + shifts
        means: list[tuple[np.complex128, np.complex128]] = []
        left = np.ones(len(turns), np.bool_)
        is_near = (
            (np.abs(np.angle(turns[:, None] / turns)) < math.radians(self.cluster_deg))
            & (np.abs(at[:, None, 1] - at[:, 1]) < self.cluster_scale)
            & (np.abs(centres[:, None] - centres) < self.cluster_shift * extent)
        )
        while left.any() and len(means) < 2 * MAX_CANDIDATES:
            members = is_near & left
            best = int(np.argmax(np.where(left, members.sum(axis=1), -1)))
            own = members[best]
            turn = turns[own].mean()
            turn *= np.exp(at[own, 1].mean()) / max(abs(turn), 1e-12)
            means.append((turn, centres[own].mean() - turn * middle))
            left &= ~own
        return means

    def _association(self, a: Boxes, b: Boxes) -> float:
        """Return the geometric mean of both maps' shares of region area that associates with the other's regions."""
        sizes_a, sizes_b = (np.sqrt(_areas(boxes)) for boxes in (a, b))
        size = np.sqrt(sizes_a[:, None] * sizes_b)
        apart = np.abs(a.mean(axis=1)[:, None] - b.mean(axis=1)) / size
        unlike = np.abs(np.log(sizes_a[:, None] / sizes_b))
        is_pair = (apart < self.associated_within) & (unlike < self.associated_within)
        shares = (
            (areas * is_matched).sum() / areas.sum()
            for areas, is_matched in ((sizes_a**2, is_pair.any(axis=1)), (sizes_b**2, is_pair.any(axis=0)))
        )
        return float(math.sqrt(math.prod(shares)))


def region_boxes(grid: OccupancyGrid, max_boxes: int) -> Boxes:
    """Find the oriented minimum bounding boxes of a map's free regions, the largest first, shape (N, 4)."""
    inside = exact_distance(~np.pad(grid.free, 1))[1:-1, 1:-1]
    boxes = []
    for level in LEVELS:
        depth = level * float(inside.max(initial=0.0))
        outlines, _ = cv2.findContours((inside > depth).view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        for outline in outlines:
            middle, (width, height), angle = cv2.minAreaRect(outline)
            sides = width + 2 * depth, height + 2 * depth  # grown back to the walls
            if min(width, height) >= 1 and min(sides) >= LEAST_SIDE_CELLS:
                corners = cv2.boxPoints((middle, sides, angle)).astype(np.float64)
                boxes.append(corners[:, 0] + 1j * corners[:, 1])
    corners_of_all = np.array(boxes, np.complex128).reshape(-1, 4)
    return corners_of_all[np.argsort(-_areas(corners_of_all), kind="stable")[:max_boxes]]


def _areas(boxes: Boxes) -> NDArray[np.float64]:
    areas: NDArray[np.float64] = np.abs(boxes[:, 1] - boxes[:, 0]) * np.abs(boxes[:, 2] - boxes[:, 1])
    return areas
