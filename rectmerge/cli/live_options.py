"""Options on the live merger, for a recording and for topics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.live.robot_names import PATTERN

if TYPE_CHECKING:
    from rectmerge.cli.method_options import MethodOptions
    from rectmerge.live.merger import LiveMerger


@dataclass(frozen=True, kw_only=True)
class LiveOptions:
    """Options on whose maps are merged, and how soon."""

    reference: Annotated[
        str, typer.Option(metavar="ROBOT", help="The robot whose map frame is kept; else the first that sends a map.")
    ] = ""
    topics: Annotated[str, typer.Option(metavar="PATTERN", help="Topics of the maps, ROBOT in place of the name.")] = (
        PATTERN
    )
    rate: Annotated[float, typer.Option(min=0.01, max=100.0, metavar="HZ", help="Most merges a second.")] = 1.0
    accepts: Annotated[
        int,
        typer.Option(min=1, max=10, metavar="N", help="Answers that must agree, on maps that changed between them."),
    ] = 2

    def make_merger(self, solving: MethodOptions) -> LiveMerger:
        """Return the merger."""
        from rectmerge.live.merger import LiveMerger
        from rectmerge.live.params import LiveParams

        return LiveMerger(
            reference=self.reference,
            method=solving.make_method(),
            scale=solving.parse_scale(),
            seed=solving.seed,
            params=LiveParams(accepts=self.accepts),
        )
