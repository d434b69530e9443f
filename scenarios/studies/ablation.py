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

from rectmerge._kernels.wall_cells import SPECK, SURFACE, describe_walls
from rectmerge.analysis import trinary_map as cells
from rectmerge.analysis import wall_faces as sides
from rectmerge.methods import make_method
from rectmerge.robust import features, hypotheses, method, search, verdict
from rectmerge.robust.refinement import Fit, fit_surfaces
from rectmerge.robust.search import Search
from rectmerge.robust.wall_agreement import WallAgreement
from scenarios.bench.asking import ask
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import score_answer
from scenarios.pairs.pair import MapPair
from scenarios.scoring.row import Row

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
            yield score_answer(pair, contender, ask(pair, contender))


def _no_two_sided_pairs(*arguments: Any) -> int:
    """Stand in for `pair_by_both_sides`: no hypothesis is added to the count, its last argument."""
    return int(arguments[-1])


def _placement_kept(placement: NDArray[np.float64], *arguments: Any, **options: Any) -> Fit:
    """Stand in for `fit_surfaces`: its measurements without its move."""
    return dataclasses.replace(fit_surfaces(placement, *arguments, **options), placement=placement)


def _no_placements(*_: Any) -> NDArray[np.float64]:
    """Stand in for what proposes placements: none."""
    return np.empty((0, 4))


def _all_faces_alike(lengths: NDArray[np.float64], *_: NDArray[np.float64], **__: float) -> NDArray[np.float64]:
    """Stand in for `run_lengths`: every face is part of a long run."""
    return np.full(len(lengths), np.inf)


def _no_odds(weights: WallAgreement, *_: NDArray[np.float64]) -> NDArray[np.float64]:
    """Stand in for one of the two models: it finds nothing plausible."""
    return np.full(len(weights.matched), -30.0)


def no_specks(values: NDArray[np.int8], occupied: NDArray[np.int64]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Stand in for the kernel `describe_walls`: specks are surface like any other."""
    kinds, normals = describe_walls(values, occupied)
    return np.where(kinds == SPECK, SURFACE, kinds).astype(np.int8), normals


ABLATIONS = (
    Ablation(name="nothing: the method as it is"),
    Ablation(
        name="rectangle pairs that agree in both sides",
        patches=((hypotheses, "pair_by_both_sides", _no_two_sided_pairs),),
    ),
    Ablation(name="removal of specks", patches=((cells, "describe_walls", no_specks), (features, "SPECK_CELLS", 0))),
    Ablation(
        name="every shift, where rectangles do not convince", patches=((Search, "by_correlation", _no_placements),)
    ),
    Ablation(name="rivals at the same scale", patches=((Search, "rivals_of", _no_placements),)),
    Ablation(name="walls apart from things", patches=((sides, "run_lengths", _all_faces_alike),)),
    Ablation(name="the model of rigid maps", patches=((search, "rigid_odds", _no_odds),)),
    Ablation(name="the model of bent maps", patches=((search, "bent_odds", _no_odds),)),
    Ablation(name="the mirror image as a rival", patches=((verdict, "SURE_AT", 0.0),)),
    Ablation(name="fit of the surfaces", patches=((method, "fit_surfaces", _placement_kept),)),
)
