"""Certificate that no placement away from the accepted one scores nearly as well, shown by branch and bound.

The search for a placement tries many and may miss one. Here boxes of placements (angle, scale, shift) are ruled out
whole, by an upper bound of what anything in them scores; what cannot be ruled out is split. A. H. Land and A. G. Doig,
Econometrica 1960, DOI 10.2307/1910129; bounds by pooled fields as in W. Hess et al., ICRA 2016,
DOI 10.1109/ICRA.2016.7487258, here for angle and scale too.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.wall_cells import known_bounds
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.analysis.wall_faces import QUARTER
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.face_score import STEPS_PER_NAT, Boxes, FaceScore, Placements, Shares, total
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import CertificateParams, Params
from rectmerge.similarity import Similarity

COMPLEX = np.array([1, 1j])


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """Certificate of an accepted placement by branch and bound. It is about a score, not about the truth.

    The score is the sum, over about 240 evenly spaced faces of the walls of both maps, of the log-likelihood ratio of
    the distance to the other map's next wall that faces the same way, of four. It is taken on the working grids, in
    steps of 1/32 nat, and is 0 where the other map is not known. `spread_cells` is how far walls of one map may lie
    from the other's: of 1, 2 and 4 cells the one under which the accepted placement scores highest; 5 % of the walls
    may be missing.

    Parameters
    ----------
    certified
        That no placement elsewhere scores as much as ``(1 - margin) * score``. Elsewhere is where some landmark of B,
        of four at the radius of its walls, lies further than 5 % of A's extent (the diagonal of the bounding box of its
        known cells) from where the accepted placement puts it, the scale being within its bounds.
    margin
        A share of the score.
    score
        Of the accepted placement, nats.
    best_elsewhere
        No placement elsewhere scores more, nats, whether certified or not.
    counterexample
        Between the pixel centres: a placement elsewhere that scores within the margin. None where none was met.
    counterexample_score
        Its score, nats.
    spread_cells
        Standard deviation of the walls' distances, in working cells.
    faces
        Faces that were asked.
    seconds
        Wall time.
    boxes
        Boxes of placements that were bounded.
    """

    certified: bool
    margin: float
    score: float
    best_elsewhere: float
    counterexample: Similarity | None = None
    counterexample_score: float | None = None
    spread_cells: float
    faces: int
    seconds: float
    boxes: int

    def __bool__(self) -> bool:
        return self.certified

    def __str__(self) -> str:
        """Return a line for the terminal."""
        spent = f"{self.boxes:,} boxes in {self.seconds:.1f} s"
        if self.certified:
            return f"yes: nothing elsewhere scores {1 - self.margin:.0%} of this placement ({spent})"
        if self.counterexample is not None and self.counterexample_score is not None:
            share = self.counterexample_score / self.score
            return f"no: a placement elsewhere scores {share:.0%} of this one ({spent})"
        if self.score <= 0:
            return "no: the walls of this placement score no better than chance"
        return f"not in time: elsewhere at most {self.best_elsewhere / self.score:.0%} of this placement ({spent})"

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        other = self.counterexample
        return values | {"counterexample": None if other is None else other.matrix.tolist()}


def certify(
    a: OccupancyGrid,
    b: OccupancyGrid,
    pixels: Similarity,
    *,
    scale: tuple[float, float],
    seconds: float,
    params: Params,
) -> Certificate:
    """Show that nothing else comes close to a placement, or meet what does, or run out of time.

    Parameters
    ----------
    a, b
        The two maps.
    pixels
        The accepted placement, from pixel centres of B to those of A.
    scale
        Bounds of the pixel scale that was searched, cells of A per cell of B; 5 % beyond them is looked at too.
    seconds
        Wall time that the search may take once the maps are read. All else is determined by the maps.
    params
        Parameters of the method.

    Raises
    ------
    InputError
        If a map has no wall beside free space, the scale is no interval of positive numbers, or the time is not
        positive.
    """
    started = time.perf_counter()
    if not 0 < scale[0] <= scale[1] < math.inf:
        raise InputError(f"scale must satisfy 0 < lo <= hi, got {scale}")
    if not seconds > 0:
        raise InputError(f"seconds must be > 0, got {seconds}")
    speck = params.prepare.max_speck_cells
    cells = [MapCells.from_values(trinary(grid), max_speck_cells=speck) for grid in (a, b)]
    features = [extract_features(each, params.prepare) for each in cells]
    if features[0] is None or features[1] is None:
        raise InputError(f"map {'A' if features[0] is None else 'B'} has no wall beside free space")
    limits = params.certificate
    score = FaceScore.from_placement(features[0], features[1], pixels, params)
    search = _Search(score, params.exact.widened(scale), _extent(a) / features[0].factor, limits)
    search.run(time.perf_counter() + seconds)
    met = search.met
    return Certificate(
        certified=search.accepted > 0 and search.highest < search.threshold,
        margin=limits.margin,
        score=search.accepted / STEPS_PER_NAT,
        best_elsewhere=search.highest / STEPS_PER_NAT,
        counterexample=None if met is None else score.to_pixels(met),
        counterexample_score=None if met is None else int(score.of_placements(met[None])[0]) / STEPS_PER_NAT,
        spread_cells=score.spread_cells,
        faces=score.faces.shape[1],
        seconds=time.perf_counter() - started,
        boxes=search.bounded,
    )


def _extent(grid: OccupancyGrid) -> float:
    """Measure the diagonal of the bounding box of a map's known cells, in cells."""
    top, bottom, left, right = known_bounds(trinary(grid))
    return math.hypot(bottom - top + 1, right - left + 1)


class _Search:
    """Branch and bound: the boxes of placements that nothing has ruled out, the most promising split first.

    Parameters
    ----------
    score
        Score of placements.
    scale
        Bounds of the pixel scale.
    extent
        Of A, in its working cells.
    params
        Limits of the search.
    """

    def __init__(self, score: FaceScore, scale: tuple[float, float], extent: float, params: CertificateParams) -> None:
        self.params = params
        self.score = score
        self.accepted = score.accepted
        self.threshold = math.ceil((1 - params.margin) * self.accepted)
        self.away = params.away_share * extent
        self.met: NDArray[np.float64] | None = None
        self.bounded = 0
        self.radius = score.b.radius
        self.landmarks = (score.b.landmarks - score.centre) @ COMPLEX
        self.kept_at = self._landmarks_at(score.given[None])
        self.boxes = _whole(score, scale)
        self.shares = score.unbounded(len(self.boxes))
        self.score.lower(self.boxes, self.shares, self.threshold)
        self.totals = total(self.shares)

    @property
    def highest(self) -> int:
        """Bound on the score of every placement elsewhere, in steps."""
        return max(self.threshold - 1, int(self.totals.max(initial=self.threshold - 1)))

    def run(self, until: float) -> None:
        """Split boxes until none is left, a placement within the margin is met, or the time is over."""
        while self.accepted > 0 and len(self.boxes) and time.perf_counter() < until:
            chosen = self._chosen()
            self.met = self._within_margin(self.boxes[chosen])
            if self.met is not None:
                return
            boxes, parents = _halves(self.boxes[chosen], self.radius)
            elsewhere = ~self._is_beside(boxes)
            boxes, shares = boxes[elsewhere], self.shares[chosen][parents[elsewhere]]
            self.score.lower(boxes, shares, self.threshold)
            self.bounded += len(boxes)
            self._replace(chosen, boxes, shares)

    def _chosen(self) -> NDArray[np.intp]:
        """Choose the boxes that are split next, those alike in succession: they look up the same fields."""
        count, batch = len(self.boxes), self.params.batch_boxes
        if count <= batch:
            chosen = np.arange(count)
        elif count > self.params.max_open_boxes:
            chosen = np.arange(count - batch, count)
        else:
            chosen = np.argpartition(-self.totals, batch - 1)[:batch]
        angles, sizes = self.boxes[chosen, 0], self.boxes[chosen, 6]
        return chosen[np.lexsort((sizes, np.rint((angles - self.score.given[0]) / QUARTER)))]

    def _replace(self, chosen: NDArray[np.intp], boxes: Boxes, shares: Shares) -> None:
        """Put what is not ruled out of the new boxes in the place of those that were split."""
        totals = total(shares)
        alive = totals >= self.threshold
        waiting = np.ones(len(self.boxes), np.bool_)
        waiting[chosen] = False
        self.boxes = np.concatenate([self.boxes[waiting], boxes[alive]])
        self.shares = np.concatenate([self.shares[waiting], shares[alive]])
        self.totals = np.concatenate([self.totals[waiting], totals[alive]])

    def _within_margin(self, boxes: Boxes) -> NDArray[np.float64] | None:
        """Look for a placement elsewhere that scores within the margin, in the middle of small boxes."""
        middles = boxes[boxes[:, 6] <= self.params.max_tried_cells, :4]
        middles = middles[self._moved(middles) > self.away]
        scores = self.score.of_placements(middles)
        if scores.max(initial=0) < self.threshold:
            return None
        best: NDArray[np.float64] = middles[np.argmax(scores)]
        return best

    def _is_beside(self, boxes: Boxes) -> NDArray[np.bool_]:
        """Mark the boxes that hold nothing but placements near the accepted one."""
        d_angle, d_log, d_shift = boxes[:, 4:].T
        grow = np.exp(d_log)
        turned = np.exp(boxes[:, 1]) * np.sqrt(grow**2 - 2 * grow * np.cos(d_angle) + 1)
        beside: NDArray[np.bool_] = self._moved(boxes) + self.radius * turned + math.sqrt(2) * d_shift <= self.away
        return beside

    def _moved(self, placements: Placements) -> NDArray[np.float64]:
        """Measure how far from the accepted placement some landmark of B is moved at the most, in A's working cells."""
        moved: NDArray[np.float64] = np.abs(self._landmarks_at(placements) - self.kept_at).max(axis=1)
        return moved

    def _landmarks_at(self, placements: Placements) -> NDArray[np.complex128]:
        linear = np.exp(placements[:, 1] + 1j * placements[:, 0])
        at: NDArray[np.complex128] = linear[:, None] * self.landmarks + (placements[:, 2:4] @ COMPLEX)[:, None]
        return at


def _whole(score: FaceScore, scale: tuple[float, float]) -> Boxes:
    """Return boxes that hold every placement under which the maps can meet, one for each quarter turn."""
    low, high = (math.log(bound * score.b.factor / score.a.factor) for bound in scale)
    height, width = score.a.free.shape
    corners = np.array(list(itertools.product((-1, score.b.free.shape[1]), (-1, score.b.free.shape[0]))))
    reach = float(np.hypot(*(corners - score.centre).T).max()) * math.exp(high)
    half = max(height, width) / 2 + reach + 1  # beyond, no face of either map falls on the other's grid
    return np.array(
        [
            [
                score.given[0] + quarter * QUARTER, (low + high) / 2, (width - 1) / 2, (height - 1) / 2,
                QUARTER / 2, (high - low) / 2, half,
            ]
            for quarter in range(-1, 3)
        ]
    )  # fmt: skip


def _halves(boxes: Boxes, radius: float) -> tuple[Boxes, NDArray[np.intp]]:
    """Split boxes along what moves points most: angle or scale in two, shift in four. Return the parts' parents too."""
    turned = (radius * np.exp(boxes[:, 1]))[:, None] * boxes[:, 4:6]  # (N, 2)
    by_shift = boxes[:, 6] > turned.max(axis=1)
    axis = np.where(by_shift, 2, np.argmax(turned, axis=1))
    halves = boxes.copy()
    halves[np.arange(len(boxes)), 4 + axis] /= 2
    children, parents = [], []
    for one, two in itertools.product((-1, 1), repeat=2):
        which = np.flatnonzero(by_shift | (two == 1))
        child = halves[which].copy()
        child[np.arange(len(which)), axis[which]] += one * child[np.arange(len(which)), 4 + axis[which]]
        child[:, 3] += np.where(by_shift[which], two * child[:, 6], 0.0)
        children.append(child)
        parents.append(which)
    return np.concatenate(children), np.concatenate(parents)
