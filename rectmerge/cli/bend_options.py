"""Option by which map B is bent onto map A where no similarity fits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.alignment import Alignment
    from rectmerge.elastic.bend import Bend
    from rectmerge.grid import OccupancyGrid

CHOICES = ("auto", "never", "always")
AUTO, NEVER, ALWAYS = CHOICES
ANY_DISTANCE_CELLS = 1e-6  # between walls, at which the test is made all the same
UnbendName = Annotated[
    str,
    typer.Option(
        "--unbend",
        metavar="|".join(CHOICES),
        help="Bend B onto A where walls held back from the fit confirm it: auto, if walls lie apart after the merge; "
        "always tries it on any merge.",
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

    def bend(self, alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Bend | None:
        """Try to bend B onto A after an accepted alignment; None where it was not tried, or nothing clearly bends."""
        from rectmerge.elastic.params import AcceptanceParams, BendParams
        from rectmerge.elastic.unbend import unbend

        if self.unbend == NEVER or not alignment:
            return None
        if self.unbend == ALWAYS:
            return unbend(
                a, b, alignment, params=BendParams(accept=AcceptanceParams(min_distance_cells=ANY_DISTANCE_CELLS))
            )
        bend, clear = unbend(a, b, alignment), AcceptanceParams().clear_distance_cells
        return bend if bend or (bend.evidence.walls_before or 0.0) >= clear else None
