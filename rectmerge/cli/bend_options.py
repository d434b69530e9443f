"""Option by which maps are bent onto each other where no similarity fits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rectmerge.alignment import Alignment
    from rectmerge.elastic.bend import Bend
    from rectmerge.elastic.params import BendParams
    from rectmerge.fleet.graph import AlignmentGraph
    from rectmerge.grid import OccupancyGrid

CHOICES = ("auto", "never", "always")
AUTO, NEVER, ALWAYS = CHOICES
ANY_DISTANCE_CELLS = 1e-6  # between walls, at which the test is made all the same
UnbendName = Annotated[
    str,
    typer.Option(
        "--unbend",
        metavar="|".join(CHOICES),
        help="Bend B onto A, or many maps onto each other, where walls held back from the fit confirm it: auto, if "
        "walls lie apart after the merge; always tries it on any merge.",
        autocompletion=list(CHOICES).copy,
    ),
]


@dataclass(frozen=True, kw_only=True)
class BendOptions:
    """Option on maps that bend.

    Parameters
    ----------
    unbend
        "auto" tries it where the walls of an accepted merge lie apart, "always" on every accepted merge.

    Raises
    ------
    InputError
        If it is another word.
    """

    unbend: UnbendName = AUTO

    def __post_init__(self) -> None:
        if self.unbend not in CHOICES:
            raise InputError(f"--unbend: {self.unbend!r} is not one of {', '.join(CHOICES)}")

    @property
    def params(self) -> BendParams | None:
        """Parameters of a bend; None where none is tried."""
        from rectmerge.elastic.params import AcceptanceParams, BendParams

        if self.unbend == NEVER:
            return None
        if self.unbend == ALWAYS:
            return BendParams(accept=AcceptanceParams(min_distance_cells=ANY_DISTANCE_CELLS))
        return BendParams()

    def is_reported(self, bend: Bend) -> bool:
        """Return whether a bend, or its refusal, is worth a line: a refusal is where walls clearly lie apart."""
        from rectmerge.elastic.params import AcceptanceParams

        is_clear = (bend.evidence.walls_before or 0.0) >= AcceptanceParams().clear_distance_cells
        return bend.accepted or self.unbend == ALWAYS or is_clear

    def bend(self, alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Bend | None:
        """Try to bend B onto A after an accepted alignment; None where it was not tried, or nothing clearly bends."""
        from rectmerge.elastic.unbend import unbend

        if self.params is None or not alignment:
            return None
        bend = unbend(a, b, alignment, params=self.params)
        return bend if self.is_reported(bend) else None

    def bend_many(
        self, graph: AlignmentGraph, maps: Mapping[str, OccupancyGrid], progress: Callable[[int], None]
    ) -> dict[str, Bend]:
        """Try to bend the maps of each component onto the others; those that do not clearly bend are left out."""
        from rectmerge.fleet.unbending import unbend_many

        if self.params is None:
            return {}
        bends = unbend_many(maps, graph, params=self.params, progress=progress)
        return {name: bend for name, bend in bends.items() if self.is_reported(bend)}
