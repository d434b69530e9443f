"""Branch and bound over boxes of placements (angle, scale, shift).

Whole boxes are ruled out by an upper bound of the score of every placement in them; the others are split. A. H. Land
and A. G. Doig, Econometrica 1960, DOI 10.2307/1910129; bounds by pooled fields as in W. Hess et al., ICRA 2016,
DOI 10.1109/ICRA.2016.7487258, here for angle and scale too.
"""

from __future__ import annotations

import itertools
import math
import time

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.wall_faces import QUARTER
from rectmerge.robust.face_score import Boxes, FaceScore, Placements, Shares, total
from rectmerge.robust.params import CertificateParams

COMPLEX = np.array([1, 1j])


class BranchAndBound:
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
