"""The plausibility of a placement from what speaks for it: two logistic models, one for rigid maps, one for bent ones.

The numbers are what `rectbench calibrate` fits to the split train of the suite `trust`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.weighing import Weights

TERMS = (
    *("one", "met", "near", "far", "log_judged", "things_met", "things_far", "log_things"),
    *("missing", "log_overlap", "root_iou", "support"),
)
RIGID = np.array([-6.0, 12.0, 0.0, -15.0, 0.0, 3.0, 0.0, 0.0, -15.0, 2.8, 5.0, 0.0])
BENT = np.array([-6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -15.3, 0.0, 11.3, 10.0])
DECOY = 1.0  # weight of the mirror image's best placement among the rivals
LEAST_OVERLAP, FEWEST_JUDGED, LARGEST_SUPPORT = 0.03, 20.0, 1.5


def terms(weights: Weights, support: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lay out what both models weigh, shape (N, len(TERMS)).

    Parameters
    ----------
    weights
        Of N placements.
    support
        Shape (N,): damped log-likelihood ratio per wall point of the map that has fewer.
    """
    columns = (
        np.ones_like(support),
        weights.met,
        weights.near,
        weights.far,
        np.log(weights.judged + FEWEST_JUDGED),
        weights.things_met,
        weights.things_far,
        np.log(weights.things + FEWEST_JUDGED),
        weights.missing,
        np.log(weights.overlap + LEAST_OVERLAP),
        np.sqrt(weights.iou),
        np.sqrt(np.clip(support, 0.0, LARGEST_SUPPORT)),
    )
    return np.stack(columns, axis=1)


def plausibility(weights: Weights, support: NDArray[np.float64]) -> NDArray[np.float64]:
    """Log-odds that placements are right, each were there no other, as rigid maps or as bent ones, shape (N,)."""
    table = terms(weights, support)
    both: NDArray[np.float64] = np.logaddexp(table @ RIGID, table @ BENT)
    return both
