"""Command `rectmerge merge`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from rectmerge.cli import console
from rectmerge.cli.app import Json
from rectmerge.cli.bend_options import BendOptions
from rectmerge.cli.map_options import MapA, MapB, PairOptions
from rectmerge.cli.merge_many import FleetOptions, MoreMaps, merge_many
from rectmerge.cli.method_options import MethodOptions
from rectmerge.cli.placement_options import PlacementOptions
from rectmerge.cli.warm_up import compile_before_first_merge
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from rectmerge.aligning import Scale
    from rectmerge.alignment import Alignment, Certificate, Method
    from rectmerge.composing.compose import CellsOf, Rule
    from rectmerge.elastic.bend import Bend
    from rectmerge.grid import OccupancyGrid
    from rectmerge.results.inputs import Input

Folder = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the results.")]
RULE_NAMES = "occupied, free, log-odds, evidence or newest"
RuleName = Annotated[
    str | None,
    typer.Option(
        "--rule",
        metavar="RULE",
        help=f"Rule where the maps differ: {RULE_NAMES}; log-odds and evidence keep shades, in mode raw. Unless given, "
        "occupied, and log-odds for more than two maps.",
        autocompletion=RULE_NAMES.replace(" or", ",").split(", ").copy,
    ),
]
Cells = Annotated[str, typer.Option(metavar="a|b|finer|METRES", help="The cells of the merged map; a keeps A's own.")]
Certify = Annotated[
    bool,
    typer.Option(
        "--certify", metavar="", help="Show that no placement elsewhere scores nearly as well as an accepted one."
    ),
]
CertifySeconds = Annotated[float, typer.Option(metavar="S", min=0.1, help="Time limit of --certify, seconds.")]
Force = Annotated[bool, typer.Option("--force", metavar="", help="Replace the results that DIR holds.")]


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Options on the merged map."""

    rule: RuleName = None
    output_resolution: Cells = "a"

    def parse(self, unless_given: Rule = "occupied") -> tuple[Rule, CellsOf | float]:
        """Return the rule and the cells of the merged map."""
        from rectmerge.composing.compose import RULES, parse_resolution

        rule = self.rule or unless_given
        if rule not in RULES:
            raise InputError(f"--rule: {rule!r} is not one of {', '.join(RULES)}")
        return rule, parse_resolution(self.output_resolution)


@dataclass(frozen=True, kw_only=True)
class CertificateOptions:
    """Options on the certificate of an accepted alignment."""

    certify: Certify = False
    certify_seconds: CertifySeconds = 10.0

    def certify_with(
        self, method: Method, alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid, scale: Scale
    ) -> Certificate | None:
        """Return the certificate of an accepted alignment, by its method or else by the default one."""
        from rectmerge.aligning import searched_scale
        from rectmerge.alignment import Certifies
        from rectmerge.methods import DEFAULT_METHOD, make_method

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
    bending: BendOptions,
    reading: PairOptions,
    fleet: FleetOptions,
    more: MoreMaps = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Place map B on map A and write the merged map, or give the reason why not.

    Where the answer is no, you can help: give a guess to search near, choose one of the candidates, or place B by hand
    in the page of `rectmerge view` and paste its numbers. A placement by hand or a chosen candidate is always merged,
    and the reason holds the verdict of the method on it.

    Where the walls of an accepted merge still lie apart, because a map bends, B is bent onto A, if walls held back from
    the fit confirm it: merged.yaml is then of the bent map, and unbend.json has the bend.

    Whatever the method, no map is written against the verdict of `rectmerge check` on its answer, unless --unchecked.

    Of more than two maps it is found which belong together; each such group is merged in the frame of its first map,
    that of A, or of --reference, as merged.yaml, and maps that bend are bent onto the others. The status is 1 where a
    map is left out, 0 where all are in one.
    """
    from rectmerge.cli.map_options import input_files, read_maps
    from rectmerge.composing.rules import SHADING
    from rectmerge.io.json_text import to_json
    from rectmerge.io.map_file import has_shades
    from rectmerge.results.alignment_json import to_json_dict
    from rectmerge.results.folder import ResultFolder
    from rectmerge.results.inputs import inputs_json_dict
    from rectmerge.results.summary import describe

    if more:
        _refuse_for_many(placing, merging, certifying, reading)
        rule, cells = merging.parse("log-odds")
        merge_many(
            reading.inputs(a, b, *more, resolutions=[None] * (2 + len(more))), output, fleet, bending,
            method=solving.make_method(), scale=solving.parse_scale(), seed=solving.seed, rule=rule, cells=cells,
            is_checked=not placing.unchecked, earlier=placing.earlier, force=force, json=json,
        )  # fmt: skip
    fleet.refuse()
    scale, (rule, cells), method = solving.parse_scale(), merging.parse(), solving.make_method()
    inputs = reading.pair(a, b)
    folder = ResultFolder(output)
    folder.check(input_files(inputs), force=force)
    if placing.earlier is not None:
        _note_other_maps(placing.earlier, inputs)
    grid_a, grid_b = read_maps(inputs)
    if cells != "a" and grid_a.resolution is None:
        raise InputError(f"{a}: its resolution is not known: give --resolution-a, or keep --output-resolution a")
    compile_before_first_merge()
    alignment = _with_quality(
        placing.align(grid_a, grid_b, method=method, scale=scale, seed=solving.seed), grid_a, grid_b
    )
    bend = bending.bend(alignment, grid_a, grid_b)
    pictures, merged = _results(alignment, grid_a, grid_b, rule, cells, bend)
    certificate = certifying.certify_with(method, alignment, grid_a, grid_b, scale)
    record = to_json_dict(alignment, grid_a, grid_b)
    record["inputs"] = inputs_json_dict(output, *inputs, grids=(grid_a, grid_b))
    if certificate is not None:
        record["certificate"] = certificate.as_dict()
    if bend is not None:
        record["unbent"] = bend.as_dict()
    is_shaded = merged is not None and rule in SHADING and has_shades(merged)
    files = folder.write(record, pictures, merged, shaded=is_shaded, bend=bend)
    console.tell(to_json(record) if json else describe(alignment, files, certificate, bend=bend, is_shaded=is_shaded))
    raise typer.Exit(console.STATUS[alignment.verdict])


def _note_other_maps(earlier: Path, inputs: Sequence[Input]) -> None:
    """Say where an earlier merge, whose placement is taken, is of other maps."""
    from rectmerge.io.atomic_file import resolve_links
    from rectmerge.results.alignment_json import AlignmentFile
    from rectmerge.results.inputs import recorded_inputs

    known = recorded_inputs(AlignmentFile.read(earlier).path)
    if known and [resolve_links(one.path) for one in known] != [resolve_links(one.path) for one in inputs]:
        was = " and ".join(one.given for one in known)
        console.note(f"rectmerge: {earlier}: is a merge of {was}; its placement is taken for other maps")


def _refuse_for_many(
    placing: PlacementOptions,
    merging: OutputOptions,
    certifying: CertificateOptions,
    reading: PairOptions,
) -> None:
    """Refuse options on one pair where there are more than two maps."""
    given = {
        "--guess": placing.guess is not None,
        "--candidate": placing.candidate is not None,
        "--pixels": placing.pixels is not None,
        "--certify": certifying.certify,
        "--resolution-a": reading.resolution_a is not None,
        "--resolution-b": reading.resolution_b is not None,
        "--output-resolution b": merging.output_resolution == "b",
    }
    if refused := [option for option, is_given in given.items() if is_given]:
        raise InputError(f"{refused[0]} is for two maps, and there are more: merge the pair by itself")


def _with_quality(alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Alignment:
    """Measure the maps' own accuracy where the method did not."""
    from rectmerge.analysis.quality import measure_quality

    measured = {"a": measure_quality(a).as_dict(), "b": measure_quality(b).as_dict()}
    return dataclasses.replace(alignment, quality=alignment.quality or measured)


def _results(
    alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid, rule: Rule, cells: CellsOf | float, bend: Bend | None
) -> tuple[dict[str, NDArray[np.uint8]], OccupancyGrid | None]:
    """Return the pictures, and the merged map if the alignment is accepted."""
    from rectmerge.composing.compose import compose
    from rectmerge.drawing.maps import draw_conflict, side_by_side
    from rectmerge.drawing.overlay import draw_overlay

    if not alignment:
        return {
            f"overlay_{number}.png": draw_overlay(a, b, candidate.pixels, title=alignment.headline(number))
            for number, candidate in enumerate(alignment.candidates, start=1)
        }, None
    pixels = alignment.candidates[0].pixels
    overlay = draw_overlay(a, b, pixels, title=alignment.headline())
    if bend:
        b = bend.straighten(b)
        overlay = side_by_side([overlay, draw_overlay(a, b, pixels, title="unbent")], ["before", "after"])
    composition = compose([a, b], [None, alignment.b_to_a], rule=rule, resolution=cells)
    return {"overlay.png": overlay, "conflict.png": draw_conflict(composition)}, composition.grid
