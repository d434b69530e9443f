"""Agreement of the walls of two maps under a placement, and of their free space."""

from __future__ import annotations

import math
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.code_counts import count_codes
from rectmerge._kernels.placements import add_scores, invert
from rectmerge.analysis.distance_codes import BINS, EDGES_CELLS, IN_UNKNOWN
from rectmerge.analysis.wall_faces import EIGHTH, WallFaces, rounded_turn
from rectmerge.robust.contradictions import measure
from rectmerge.robust.detailed_map import DetailedMap
from rectmerge.robust.features import Features
from rectmerge.robust.params import Params, RankParams

CODES = 128
LONG, CLUTTER = np.uint8(1), np.uint8(2)  # kinds of faces, in long straight runs and not
KINDS = 2
Value = TypeVar("Value")


class WallAgreement(NamedTuple, Generic[Value]):
    """Agreement of the walls under placements: numbers of one placement, or of N in arrays of shape (N,).

    Parameters
    ----------
    judged
        Faces of walls that fall where the other map is known, of both maps, counted by the coarser map's cells.
    matched, near, contradicted
        Shares of these within 1.5 cells of a face of the other map with the same normal, within 4, and beyond 8.
    clutter, clutter_matched, clutter_contradicted
        The same of faces that are in no long run: things may have been moved between the visits.
    violations
        Share of the walls on known cells of the other map that lie deep in its free space, whatever their normal.
    overlap, iou
        Of the free space: over the smaller area, and over the union.
    on_floor
        Share of the faces on solid floor of the other map: free, and far from any wall and from the unknown.
    beside
        Share of the long faces on free cells of the other map, a little away from any wall and from the unknown.
    corners_missed, corners_denied
        Shares of the corners that the other map must show and does not, and where it shows solid floor.
    """

    judged: Value
    matched: Value
    near: Value
    contradicted: Value
    clutter: Value
    clutter_matched: Value
    clutter_contradicted: Value
    violations: Value
    overlap: Value
    iou: Value
    on_floor: Value
    beside: Value
    corners_missed: Value
    corners_denied: Value


Agreements = WallAgreement[NDArray[np.float64]]


def take(agreements: Agreements, indices: NDArray[np.intp]) -> Agreements:
    """Return some of the placements, in this order."""
    return WallAgreement(*(values[indices] for values in agreements))


def concat(first: Agreements, second: Agreements) -> Agreements:
    """Return the placements of both, the first ones first."""
    return WallAgreement(*(np.concatenate(both) for both in zip(first, second, strict=True)))


def at(agreements: Agreements, index: int) -> WallAgreement[float]:
    """Return the agreement of one placement."""
    return WallAgreement(*(float(values[index]) for values in agreements))


class AgreementScorer:
    """Scorer of the agreement of two maps under placements of B on A.

    Parameters
    ----------
    working, detailed
        Features of A and B, and their details.
    angles
        Of normal 0 of the faces of A and B, radians: the strongest direction of their walls.
    params
        Parameters of the method.
    """

    def __init__(
        self,
        working: tuple[Features, Features],
        detailed: tuple[DetailedMap, DetailedMap],
        angles: tuple[float, float],
        params: Params,
    ) -> None:
        self._working, self._detailed, self._contradict = working, detailed, params.contradict
        (a, b), (self._angle, self._angle_b) = working, angles
        self._a, self._b = a, b
        self._faces, self._params = params.faces, params.rank
        self._on_a = a.faces(self._angle, params.faces)
        self._floor = _floor_sample(b.free, params.rank.max_free_samples)

    def score(self, placements: NDArray[np.float64]) -> Agreements:
        """Score placements, rows (a, b, tx, ty) between the working grids."""
        long_faces, clutter_faces = self._codes_met(placements)
        judged, matched, near, contradicted = _shares(long_faces, self._params)
        clutter, clutter_matched, _, clutter_contradicted = _shares(clutter_faces, self._params)
        overlap, iou = self._overlaps(placements)
        contradictions = measure(placements, self._working, self._detailed, self._contradict)
        return WallAgreement(
            judged=judged,
            matched=matched,
            near=near,
            contradicted=contradicted,
            clutter=clutter,
            clutter_matched=clutter_matched,
            clutter_contradicted=clutter_contradicted,
            violations=self._violations(placements),
            overlap=overlap,
            iou=iou,
            **contradictions._asdict(),
        )

    def _codes_met(self, placements: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Count the codes that long faces and others of both maps meet, by the coarser map's cells, (N, CODES) each.

        Of the eight ways of B's own frame those four are counted that a placement brings nearest to A's normals.
        """
        back = invert(placements)
        turns = np.arctan2(placements[:, 1], placements[:, 0])
        quarters, oblique = rounded_turn(self._angle - turns - self._angle_b)  # from B's normals to A's
        forward = np.zeros((len(placements), KINDS, CODES), np.int32)
        backward = np.zeros_like(forward)
        for is_oblique in np.unique(oblique).tolist():
            which = np.flatnonzero(oblique == is_oblique)
            on_b = self._b.faces(self._angle_b + is_oblique * EIGHTH, self._faces)
            of_a, of_b = _kinds(self._on_a), _kinds(on_b)
            forward[which] = _tallied(placements[which], -quarters[which] % 4, self._b.walls, of_b, self._on_a.codes)
            backward[which] = _tallied(back[which], quarters[which] % 4, self._a.walls, of_a, on_b.codes)
        long_faces, clutter = np.moveaxis(_by_coarser_cells(placements, forward, backward), 1, 0)
        return long_faces, clutter

    def _overlaps(self, placements: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Estimate the overlap over the smaller free space and over the union, from evenly spaced free cells of B."""
        hits = np.zeros(len(placements), np.int64)
        add_scores(placements, self._floor, self._a.free.astype(np.int32), hits)
        area_a = np.count_nonzero(self._a.free)
        area_b = np.count_nonzero(self._b.free) * (placements[:, :2] ** 2).sum(axis=1)
        common = np.minimum(hits / max(1, self._floor.shape[1]) * area_b, np.minimum(area_a, area_b))
        return common / np.maximum(1.0, np.minimum(area_a, area_b)), common / np.maximum(1.0, area_a + area_b - common)

    def _violations(self, placements: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the walls on known cells of the other map that lie deep in its free space, shape (N,)."""
        ways = np.zeros(len(placements), np.int64)
        one, two = (np.ones((len(f.walls), 1), np.uint8) for f in (self._a, self._b))
        forward = _tallied(placements, ways, self._b.walls, two, self._a.distance_bins[None])
        backward = _tallied(invert(placements), ways, self._a.walls, one, self._b.distance_bins[None])
        counts = _by_coarser_cells(placements, forward, backward)[:, 0]
        known = counts[:, :BINS].sum(axis=1) + _within(counts[:, IN_UNKNOWN:], self._params.known_beside_cells)
        violations: NDArray[np.float64] = _beyond(counts, self._params.contradicted_cells) / np.maximum(known, 1.0)
        return violations


def _within(counts: NDArray[np.float64], cells: float) -> NDArray[np.float64]:
    """Sum the counts of distances below an edge of bins, shape (N,)."""
    sums: NDArray[np.float64] = counts[:, : int(np.searchsorted(EDGES_CELLS, cells))].sum(axis=1)
    return sums


def _shares(counts: NDArray[np.float64], params: RankParams) -> tuple[NDArray[np.float64], ...]:
    """Return the number of judged faces by the codes they met, and their shares matched, near and contradicted."""
    free, beyond = counts[:, :BINS], counts[:, IN_UNKNOWN : IN_UNKNOWN + BINS]
    judged = free.sum(axis=1) + _within(beyond, params.near_cells / 2)
    some = np.maximum(judged, 1.0)
    matched = (_within(free, params.matched_cells) + _within(beyond, params.matched_cells)) / some
    near = (_within(free, params.near_cells) + _within(beyond, params.near_cells / 2)) / some
    return judged, matched, near, _beyond(free, params.contradicted_cells) / some


def _beyond(counts: NDArray[np.float64], cells: float) -> NDArray[np.float64]:
    """Sum the counts of distances from an edge of bins on, shape (N,)."""
    sums: NDArray[np.float64] = counts[:, int(np.searchsorted(EDGES_CELLS, cells)) : BINS].sum(axis=1)
    return sums


def _floor_sample(free: NDArray[np.bool_], most: int) -> NDArray[np.float32]:
    """Return about `most` free cells on a lattice about the middle, shape (2, N): the same ones of a turned map."""
    step = math.ceil(math.sqrt(np.count_nonzero(free) / most)) or 1
    rows, cols = (np.flatnonzero(np.abs(2 * np.arange(side) - (side - 1)) // 2 % step == 0) for side in free.shape)
    v, u = np.nonzero(free[np.ix_(rows, cols)])
    if len(v) == 0:  # narrow passages between the lines of the lattice
        return np.stack(np.nonzero(free)[::-1]).astype(np.float32)
    return np.stack([cols[u], rows[v]]).astype(np.float32)


def _kinds(sides: WallFaces) -> NDArray[np.uint8]:
    """Return the kind of face that each wall point has by normal, shape (N, 4), 0 where it has none."""
    return np.where(sides.faces, np.where(sides.is_long, LONG, CLUTTER), np.uint8(0))


def _tallied(
    placements: NDArray[np.float64],
    quarters: NDArray[np.int64],
    points: NDArray[np.float64],
    kinds: NDArray[np.uint8],
    codes: NDArray[np.uint8],
) -> NDArray[np.int32]:
    """Count the codes that faces meet, by kind, shape (N, kinds, CODES)."""
    counts = np.zeros((len(placements), KINDS, CODES), np.int32)
    count_codes(placements, quarters, points, kinds, codes, counts)
    return counts


def _by_coarser_cells(
    placements: NDArray[np.float64], forward: NDArray[np.int32], backward: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Add up what both maps' points met; where cells differ in size, the finer map's points count for less."""
    scales = np.hypot(placements[:, 0], placements[:, 1])[:, None, None]
    return np.asarray(forward * np.minimum(1.0, scales) + backward * np.minimum(1.0, 1 / scales), np.float64)
