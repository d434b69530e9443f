"""Ablations of the method `robust`: one of its stages off at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rectmerge.methods import make_method
from scenarios.bench.asking import ask
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import score_answer
from scenarios.pairs.pair import MapPair
from scenarios.scoring.row import Row


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """Ablation: one change to the method.

    Parameters
    ----------
    name
        The stage that is off or smaller, as in the table.
    fields
        Fields of the method, as ``--set`` names them.
    """

    name: str
    fields: Mapping[str, bool | int | float] = field(default_factory=dict)

    def contender(self) -> Contender:
        """Return the changed method under the name of the change."""
        return Contender(label=self.name, method=make_method("robust", **dict(self.fields)))


def ablated_rows(ablation: Ablation, pairs: Sequence[MapPair]) -> Iterator[Row]:
    """Yield the scored rows of the changed method on every pair."""
    contender = ablation.contender()
    for pair in pairs:
        yield score_answer(pair, contender, ask(pair, contender))


ABLATIONS = (
    Ablation(name="nothing: the method as it is"),
    Ablation(name="rectangle pairs that agree in both sides", fields={"propose.use_two_sided": False}),
    Ablation(name="removal of specks", fields={"prepare.max_speck_cells": 0, "prepare.max_speck_weight": 0}),
    Ablation(name="every shift, where rectangles do not convince", fields={"propose.use_correlation": False}),
    Ablation(name="all angles", fields={"all_round.is_used": False}),
    Ablation(name="rivals at the same scale", fields={"propose.use_rivals": False}),
    Ablation(name="walls apart from things", fields={"faces.min_run_cells": 0.0}),
    Ablation(name="the model of rigid maps", fields={"confidence.use_rigid": False}),
    Ablation(name="the model of bent maps", fields={"confidence.use_bent": False}),
    Ablation(name="the mirror image as a rival", fields={"verdict.sure_at": 0.0}),
    Ablation(name="fit of the surfaces", fields={"exact.use_fit": False}),
)
