"""The method `robust` with one of its stages off at a time: what earns its place."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.methods import make_method
from rectmerge.robust import features, hypotheses, method, search, verdict
from rectmerge.robust.features import dominant_angles
from rectmerge.robust.likelihood import JUDGED_NOISES, Judge
from rectmerge.robust.refinement import Fit, fit_surfaces
from rectmerge.robust.search import free_overlap
from scenarios.pairs import MapPair
from scenarios.rows import Contender, Row, answer, row_of

Patch = tuple[ModuleType | type, str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """One change to the method, and nothing else.

    Parameters
    ----------
    name
        What is off or smaller.
    patches
        (module or class, name, value): what the name stands for there while the change lasts. The method offers no
        options for its stages, and needs none outside of this table.
    fields
        Fields of the method.
    """

    name: str
    patches: tuple[Patch, ...] = ()
    fields: tuple[tuple[str, int], ...] = ()

    @contextmanager
    def applied(self) -> Iterator[Contender]:
        """Make the change for the length of the body, in this process, and hand out the method to ask."""
        before = [(module, name, getattr(module, name)) for module, name, _ in self.patches]
        try:
            for module, name, value in self.patches:
                setattr(module, name, value)
            yield Contender(label=self.name, method=make_method("robust", **dict(self.fields)))
        finally:
            for module, name, value in before:
                setattr(module, name, value)


def ablated_rows(ablation: Ablation, pairs: Sequence[MapPair]) -> Iterator[Row]:
    """Put the changed method to every pair."""
    with ablation.applied() as contender:
        for pair in pairs:
            yield row_of(pair, contender, answer(pair, contender))


def _no_two_sided_pairs(*arguments: Any) -> int:
    """Stand in for `pair_by_both_sides`: no hypothesis is added to the count, its last argument."""
    return int(arguments[-1])


def _full_overlap(placement: NDArray[np.float64], a: features.Features, b: features.Features) -> tuple[float, float]:
    """Stand in for `free_overlap` where the ranking reads it: the overlap damps nothing, the rest is as it was."""
    return 1.0, free_overlap(placement, a, b)[1]


def _placement_kept(placement: NDArray[np.float64], *arguments: Any, **options: Any) -> Fit:
    """Stand in for `fit_surfaces`: its measurements without its move."""
    return dataclasses.replace(fit_surfaces(placement, *arguments, **options), placement=placement)


def _no_bent_score(judge: Judge, placements: NDArray[np.float64]) -> NDArray[np.float64]:
    """Stand in for `Judge.score_bent`: no placement gains from blocks that shift by themselves."""
    return np.zeros(len(placements))


def _strongest_angle(map_features: features.Features) -> list[tuple[float, float]]:
    """Stand in for `dominant_angles`: the first direction only."""
    return dominant_angles(map_features, most=1)


def shrink_with_specks(
    cells: NDArray[np.int8], bounds: tuple[int, int, int, int], factor: float
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], int]:
    """Stand in for the kernel `shrink`, which leaves specks out: the same counts and sums with every occupied cell."""
    top, bottom, left, right = bounds
    part = cells[top : bottom + 1, left : right + 1]
    shape = tuple(int(np.ceil(side / factor)) for side in part.shape)
    row, col = (
        np.minimum(n - 1, np.floor((np.arange(side) + 0.5) / factor)) for n, side in zip(shape, part.shape, strict=True)
    )
    at = (row[:, None] * shape[1] + col).astype(np.intp)  # working cell of each cell
    around = np.pad(cells == 0, 1)
    height, width = cells.shape
    beside_free = np.any([around[i : i + height, j : j + width] for i in range(3) for j in range(3)], axis=0)
    occupied = part > 0
    surface = occupied & beside_free[top : bottom + 1, left : right + 1]
    v, u = np.indices(part.shape)

    def total(mask: NDArray[np.bool_], weights: NDArray[Any] | None = None) -> NDArray[Any]:
        heavy = None if weights is None else weights[mask]
        return np.bincount(at[mask], heavy, shape[0] * shape[1]).reshape(shape)

    counts = [total(mask).astype(np.int32) for mask in (part == 0, occupied, surface)]
    return counts[0], counts[1], counts[2], total(surface, np.add(u, left)), total(surface, np.add(v, top)), 0


_NOISES = dict(zip(("rigid", "drifting", "bent"), JUDGED_NOISES, strict=True))
ABLATIONS = (
    Ablation(name="nothing: the method as it is"),
    Ablation(name="rectangle pairs that agree in one side", patches=((hypotheses, "PLENTY", 0),)),
    Ablation(
        name="rectangle pairs that agree in both sides",
        patches=((hypotheses, "pair_by_both_sides", _no_two_sided_pairs),),
    ),
    Ablation(name="80 rectangles for 200", fields=(("rectangles", 80),)),
    Ablation(name="40 rectangles for 200", fields=(("rectangles", 40),)),
    Ablation(name="40 refined for 120", fields=(("refined", 40),)),
    Ablation(name="second orthogonal frame", patches=((method, "dominant_angles", _strongest_angle),)),
    Ablation(name="frames all round", patches=((method, "WEAK_CONTRAST", 0.0),)),
    Ablation(name="finer grid for narrow passages", patches=((features, "LARGEST_DIAGONAL_CELLS", 400.0),)),
    Ablation(
        name="removal of specks", patches=((features, "shrink", shrink_with_specks), (features, "SPECK_CELLS", 0))
    ),
    Ablation(name="damping by the overlap", patches=((search, "free_overlap", _full_overlap),)),
    *(
        Ablation(
            name=f"wall noises other than {name}", patches=((search, "JUDGED_NOISES", (noise,) * len(JUDGED_NOISES)),)
        )
        for name, noise in _NOISES.items()
    ),
    Ablation(name="walls that bend block by block", patches=((Judge, "score_bent", _no_bent_score),)),
    Ablation(name="rigid and bent forms", patches=((search, "ONTO_RIGID", ()), (search, "ONTO_BENT", ()))),
    Ablation(name="fit of the surfaces", patches=((method, "fit_surfaces", _placement_kept),)),
    *(
        Ablation(name=f"verdict's term {name}", patches=((verdict, name.upper(), 0.0),))
        for name in ("rival", "missing", "contradiction")
    ),
)
