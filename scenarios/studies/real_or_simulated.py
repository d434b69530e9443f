"""Classifier that must tell simulated maps from real ones by their descriptors: a random forest of scikit-learn.

Its area under the curve is 0.5 where the descriptors of both populations are distributed alike, jointly, and 1 where
every map is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.studies.map_population import DescribedMap
from scenarios.studies.noise_fit import WORSE

TREES, FOLDS, LEAST_LEAF = 300, 5, 2  # source: the first two are conventions, the last hand
AREA_FACTOR = 1.5  # between the free areas, in cells, of a real map and the simulated one that it is matched with


@dataclass(frozen=True, slots=True, eq=False)
class Telling:
    """Success of a classifier.

    Parameters
    ----------
    auc
        Area under its curve, of maps whose place or family took no part in the fit.
    maps
        Number of maps of each population.
    simulated
        The simulated maps that were matched.
    realness
        Probability of each of these to be real, by the classifier, shape (N,).
    importances
        Share of each descriptor in the decisions of a forest grown on all maps, by name.
    """

    auc: float
    maps: int
    simulated: Sequence[DescribedMap]
    realness: NDArray[np.float64]
    importances: dict[str, float]


def tell_apart(real: Sequence[DescribedMap], simulated: Sequence[DescribedMap], *, seed: int = 0) -> Telling:
    """Train a classifier on both populations, matched in free area, in folds by place and family.

    Parameters
    ----------
    real, simulated
        The populations; of each the maps that have a partner of like free area in the other take part.
    seed
        Of the folds and of the trees.
    """
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import roc_auc_score
    from sklearn.model_selection import StratifiedGroupKFold, cross_val_predict

    pairs = matched(real, simulated)
    maps = [real[i] for i, _ in pairs] + [simulated[j] for _, j in pairs]
    features = np.array([[one.descriptors.get(name, np.nan) for name in WORSE] for one in maps])  # (2 N, 14)
    is_real = np.repeat([1, 0], len(pairs))
    groups = [f"real {real[i].group}" for i, _ in pairs] + [f"simulated {simulated[j].group}" for _, j in pairs]
    forest = RandomForestClassifier(TREES, min_samples_leaf=LEAST_LEAF, random_state=seed)
    folds = StratifiedGroupKFold(FOLDS, shuffle=True, random_state=seed)
    guesses = cross_val_predict(forest, features, is_real, groups=groups, cv=folds, method="predict_proba")[:, 1]
    forest.fit(features, is_real)
    return Telling(
        auc=float(roc_auc_score(is_real, guesses)),
        maps=len(pairs),
        simulated=maps[len(pairs) :],
        realness=guesses[len(pairs) :],
        importances=dict(zip(WORSE, forest.feature_importances_.tolist(), strict=True)),
    )


def matched(first: Sequence[DescribedMap], second: Sequence[DescribedMap]) -> list[tuple[int, int]]:
    """Match maps of two populations one to one, as alike in free area as can be, at most a factor of 1.5 apart."""
    from scipy.optimize import linear_sum_assignment

    areas = [np.log([max(1, one.free_cells) for one in population]) for population in (first, second)]
    apart = np.abs(areas[0][:, None] - areas[1])  # (A, B)
    pairs = zip(*linear_sum_assignment(np.minimum(apart, 10 * np.log(AREA_FACTOR))), strict=True)
    return [(int(i), int(j)) for i, j in pairs if apart[i, j] <= np.log(AREA_FACTOR)]


def halves_auc(real: Sequence[DescribedMap], *, splits: int = 5) -> float:
    """Return the mean area under the curve of one half of the real places against the other, over several splits."""
    places = sorted({one.group for one in real})
    areas = []
    for seed in range(splits):
        half = set(np.random.default_rng(seed).permutation(places)[: len(places) // 2].tolist())
        first, second = ([one for one in real if (one.group in half) == is_first] for is_first in (True, False))
        areas.append(tell_apart(first, second, seed=seed).auc)
    return float(np.mean(areas))
