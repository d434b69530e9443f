"""The command `rectmerge merge`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer
from typer.core import TyperCommand

from rectmerge.cli import console
from rectmerge.cli.app import Json
from rectmerge.cli.map_options import MapA, MapB, PairOptions
from rectmerge.cli.method_options import MethodOptions
from rectmerge.cli.placement_options import PlacementOptions
from rectmerge.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rectmerge.alignment import Alignment, Certificate, Method
    from rectmerge.composing.compose import CellsOf, Rule
    from rectmerge.grid import OccupancyGrid
    from rectmerge.methods import Scale

UsageError: Any = typer.BadParameter.__bases__[0]  # click's, which typer brings from elsewhere in every second version
Folder = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the results.")]
RULE_NAMES = "occupied, free, log-odds, evidence or newest"
RuleName = Annotated[
    str,
    typer.Option(
        "--rule",
        metavar="RULE",
        help=f"What wins where maps differ: {RULE_NAMES}; log-odds and evidence keep shades, in mode raw.",
        autocompletion=RULE_NAMES.replace(" or", ",").split(", ").copy,
    ),
]
Cells = Annotated[str, typer.Option(metavar="a|b|finer|METRES", help="The cells of the merged map; a keeps A's own.")]
Certify = Annotated[
    bool, typer.Option("--certify", metavar="", help="Of a yes, show that nothing elsewhere scores nearly as well.")
]
CertifySeconds = Annotated[float, typer.Option(metavar="S", min=0.1, help="Time that --certify may take.")]
Force = Annotated[bool, typer.Option("--force", metavar="", help="Replace the results that DIR holds.")]


class TwoMaps(TyperCommand):
    """A command for two maps that tells people with more how to go on."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse a command line as every command does."""
        try:
            return super().parse_args(ctx, args)
        except UsageError as error:
            if "unexpected extra argument" not in error.message:
                raise
            how = "maps are merged two at a time: merge the first two, then their merged.yaml with the next"
            raise UsageError(f"{error.message}; {how}", ctx) from None


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Options on the merged map."""

    rule: RuleName = "occupied"
    output_resolution: Cells = "a"

    def parse(self) -> tuple[Rule, CellsOf | float]:
        """Return the rule and the cells of the merged map."""
        from rectmerge.composing.compose import RULES, parse_resolution

        if self.rule not in RULES:
            raise typer.BadParameter(f"{self.rule!r} is not one of {', '.join(RULES)}: --rule")
        return self.rule, parse_resolution(self.output_resolution)


@dataclass(frozen=True, kw_only=True)
class CertificateOptions:
    """Options on the certificate of an accepted answer."""

    certify: Certify = False
    certify_seconds: CertifySeconds = 10.0

    def certify_with(
        self, method: Method, alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid, scale: Scale
    ) -> Certificate | None:
        """Return the certificate of an accepted alignment, by its method or else by the default one."""
        from rectmerge.alignment import Certifies
        from rectmerge.methods import DEFAULT_METHOD, make_method, searched_scale

        if not (alignment and self.certify):
            return None
        certifier = method if isinstance(method, Certifies) else cast("Certifies", make_method(DEFAULT_METHOD))
        bounds, pixels = searched_scale(scale, alignment.scale), alignment.candidates[0].pixels
        return certifier.certify(a, b, pixels, scale=bounds, seconds=self.certify_seconds)


def merge(
    a: MapA,
    b: MapB,
    output: Folder,
    solving: MethodOptions,
    placing: PlacementOptions,
    merging: OutputOptions,
    certifying: CertificateOptions,
    reading: PairOptions,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find how map B fits on map A and write the merged map, or say why not.

    Where the answer is no, people can help: by a guess to search near, by choosing one of the candidates, or by placing
    B by hand in the page of `rectmerge view` and pasting its numbers back. What is placed by hand or chosen is merged,
    and the reason says what the walls make of it.

    Whatever the method, no map is written against the verdict of `rectmerge check` on its answer, unless --unchecked.
    """
    from rectmerge.cli.map_options import input_files, read_maps
    from rectmerge.composing.rules import SHADING
    from rectmerge.io.json_text import to_json
    from rectmerge.io.map_file import has_shades
    from rectmerge.results.alignment_json import to_json_dict
    from rectmerge.results.folder import ResultFolder
    from rectmerge.results.inputs import told_inputs
    from rectmerge.results.summary import describe

    scale, (rule, cells), method = solving.parse_scale(), merging.parse(), solving.make_method()
    inputs = reading.pair(a, b)
    folder = ResultFolder(output)
    folder.check(input_files(inputs), force=force)
    grid_a, grid_b = read_maps(inputs)
    if cells != "a" and grid_a.resolution is None:
        raise InputError(f"{a}: its resolution is not known: give --resolution-a, or keep --output-resolution a")
    alignment = _with_quality(
        placing.align(grid_a, grid_b, method=method, scale=scale, seed=solving.seed), grid_a, grid_b
    )
    pictures, merged = _results(alignment, grid_a, grid_b, rule, cells)
    certificate = certifying.certify_with(method, alignment, grid_a, grid_b, scale)
    record = to_json_dict(alignment, grid_a, grid_b) | {"inputs": told_inputs(output, *inputs, grids=(grid_a, grid_b))}
    if certificate is not None:
        record["certificate"] = certificate.as_dict()
    is_shaded = merged is not None and rule in SHADING and has_shades(merged)
    files = folder.write(record, pictures, merged, shaded=is_shaded)
    typer.echo(to_json(record) if json else describe(alignment, files, certificate, is_shaded=is_shaded))
    raise typer.Exit(console.STATUS[alignment.verdict])


def _with_quality(found: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Alignment:
    """Measure the maps' own accuracy where the method did not."""
    from rectmerge.analysis.quality import measure_quality

    measured = {"a": measure_quality(a).as_dict(), "b": measure_quality(b).as_dict()}
    return dataclasses.replace(found, quality=found.quality or measured)


def _results(
    found: Alignment, a: OccupancyGrid, b: OccupancyGrid, rule: Rule, cells: CellsOf | float
) -> tuple[dict[str, NDArray[np.uint8]], OccupancyGrid | None]:
    """Draw what is to be written, and merge the maps if the answer is yes."""
    from rectmerge.composing.compose import compose
    from rectmerge.drawing.maps import draw_conflict
    from rectmerge.drawing.overlay import draw_overlay

    if not found:
        numbered = enumerate(found.candidates, start=1)
        return {f"overlay_{i}.png": draw_overlay(a, b, c.pixels, title=found.headline(i)) for i, c in numbered}, None
    composition = compose([a, b], [None, found.b_to_a], rule=rule, resolution=cells)
    overlay = draw_overlay(a, b, found.candidates[0].pixels, title=found.headline())
    return {"overlay.png": overlay, "conflict.png": draw_conflict(composition)}, composition.grid
