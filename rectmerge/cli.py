"""The command `rectmerge`: merge two maps, inspect one, list the methods."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from rectmerge import console
from rectmerge.errors import InputError
from rectmerge.transformcommand import transform
from rectmerge.viewcommand import view

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    import numpy as np
    from numpy.typing import NDArray

    from rectmerge.alignment import Alignment, Candidate, Method
    from rectmerge.composition import Rule
    from rectmerge.grid import OccupancyGrid
    from rectmerge.methods import Scale
    from rectmerge.robust.certificate import Certificate

DOUBTFUL = 0.9  # below this confidence a yes asks to be looked at
app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)

MapA = Annotated[Path, typer.Argument(metavar="A", help="A ROS map's .yaml, or a plain image; its frame is kept.")]
MapB = Annotated[Path, typer.Argument(metavar="B", help="The map that is placed on A.")]
Folder = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the results.")]
MethodName = Annotated[str | None, typer.Option("--method", metavar="NAME", help="See `rectmerge methods`.")]
ScaleText = Annotated[
    str, typer.Option("--scale", metavar="auto|free|LO:HI|S", help="What is known of cells of A per cell of B.")
]
RuleName = Annotated[str, typer.Option("--rule", metavar="occupied|free|log-odds", help="What wins where maps differ.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same maps and seed, same answer.")]
Fields = Annotated[list[str] | None, typer.Option("--set", metavar="METHOD.FIELD=VALUE", help="Set a method's field.")]
Certify = Annotated[
    bool, typer.Option("--certify", metavar="", help="Of a yes, show that nothing elsewhere scores nearly as well.")
]
CertifySeconds = Annotated[float, typer.Option(metavar="S", min=0.1, help="Time that --certify may take.")]
Force = Annotated[bool, typer.Option("--force", metavar="", help="Replace the results that DIR holds.")]
Json = Annotated[bool, typer.Option("--json", metavar="", help="Print JSON instead of text.")]
Grey = Annotated[int | None, typer.Option(min=0, max=255, help="Grey level in plain images; guessed unless given.")]
Strict = Annotated[
    bool, typer.Option("--strict-thresholds", help="Obey a YAML whose free_thresh turns unknown space free.")
]


@app.callback()
def common(version: console.Version = False) -> None:
    """Merge 2-D occupancy-grid maps of unknown rotation, scale and translation.

    Exit status: 0 yes, 1 no, 2 bad input or use, 3 ambiguous, 70 internal error, 130 interrupted.
    """


@app.command()
def merge(
    a: MapA,
    b: MapB,
    output: Folder,
    method: MethodName = None,
    scale: ScaleText = "auto",
    rule: RuleName = "occupied",
    seed: Seed = 0,
    fields: Fields = None,
    certify: Certify = False,
    certify_seconds: CertifySeconds = 10.0,
    force: Force = False,
    json: Json = False,
    free: Grey = None,
    occupied: Grey = None,
    unknown: Grey = None,
    strict_thresholds: Strict = False,
    quiet: console.Quiet = False,
    debug: console.Debug = False,
) -> None:
    """Find how map B fits on map A and write the merged map, or say why not."""
    from rectmerge.inputs import told_inputs
    from rectmerge.methods import align
    from rectmerge.resultfolder import ResultFolder, to_json

    bounds, wins = _parse_scale(scale), _check_rule(rule)
    solver = _make_method(method, fields or [])
    folder = ResultFolder(output)
    folder.check(_input_files(a, b), force=force)
    levels = {"free": free, "occupied": occupied, "unknown": unknown}
    grid_a, grid_b = _read_maps([a, b], levels, strict=strict_thresholds, quiet=quiet)
    found = _with_quality(align(grid_a, grid_b, method=solver, scale=bounds, seed=seed), grid_a, grid_b)
    pictures, merged = _results(found, grid_a, grid_b, wins)
    certificate = _certify(found, grid_a, grid_b, bounds, certify_seconds) if found and certify else None
    told = _told(found, grid_a, grid_b) | ({"certificate": certificate.as_dict()} if certificate is not None else {})
    told["inputs"] = told_inputs(output, a, b, levels=levels, strict=strict_thresholds)
    files = folder.write(told, pictures, merged)
    typer.echo(to_json(told) if json else _describe(found, files, certificate))
    raise typer.Exit(console.STATUS[found.verdict])


@app.command()
def inspect(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="A ROS map's .yaml, or a plain image.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="PICTURE.png", help="The picture to write.")],
    json: Json = False,
    free: Grey = None,
    occupied: Grey = None,
    unknown: Grey = None,
    strict_thresholds: Strict = False,
    quiet: console.Quiet = False,
    debug: console.Debug = False,
) -> None:
    """Draw a map's rectangles and orientation, and tell its size and its own accuracy."""
    from rectmerge.imagefile import encode_image, replace_file
    from rectmerge.inspection import inspect_map
    from rectmerge.resultfolder import to_json

    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: the picture is a PNG; give it a name that ends in .png")
    if output.resolve() in {file.resolve() for file in _input_files(map_file)}:
        raise InputError(f"{output}: is the map itself; name another picture with -o")
    levels = {"free": free, "occupied": occupied, "unknown": unknown}
    (grid,) = _read_maps([map_file], levels, strict=strict_thresholds, quiet=quiet)
    inspection = inspect_map(grid)
    replace_file(output, encode_image(inspection.draw(), ".png"))
    typer.echo(to_json(inspection.as_dict()) if json else f"{inspection}\n  picture      {output}")


@app.command()
def methods(json: Json = False, quiet: console.Quiet = False, debug: console.Debug = False) -> None:
    """List the methods and the fields that --set takes."""
    from rectmerge.methods import DEFAULT_METHOD, available
    from rectmerge.resultfolder import to_json

    found = {name: _describe_method(point) for name, point in available().items()}
    if json:
        typer.echo(to_json({"default": DEFAULT_METHOD, "methods": found}))
        return
    for name, method in found.items():
        default = " (default)" if name == DEFAULT_METHOD else ""
        typer.echo(f"{name}{default}: {method['about']}")
        for field, value in method["fields"].items():
            typer.echo(f"    --set {name}.{field}={value}")


app.command()(transform)
app.command()(view)


def main() -> None:
    """Run the command and exit with its status."""
    sys.exit(console.run(app, "rectmerge"))


def _parse_scale(text: str) -> Scale:
    if text in ("auto", "free"):
        return cast("Scale", text)
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not 0 < numbers[0] <= numbers[-1] < math.inf:
        raise typer.BadParameter(f"{text!r} is not auto, free, LO:HI with 0 < LO <= HI, or a positive number: --scale")
    return numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])


def _check_rule(rule: str) -> Rule:
    from rectmerge.composition import RULES

    if rule not in RULES:
        raise typer.BadParameter(f"{rule!r} is not one of {', '.join(RULES)}: --rule")
    return rule


def _make_method(name: str | None, assignments: Sequence[str]) -> Method:
    """Make the method with the fields that ``--set METHOD.FIELD=VALUE`` names."""
    from rectmerge.methods import DEFAULT_METHOD, make_method

    name = name or DEFAULT_METHOD
    fields: dict[str, object] = {}
    for assignment in assignments:
        target, equals, value = assignment.partition("=")
        owner, dot, field = target.partition(".")
        if not (equals and dot and field):
            raise typer.BadParameter(f"{assignment!r} is not METHOD.FIELD=VALUE: --set")
        if owner != name:
            raise typer.BadParameter(f"{assignment!r} sets a field of {owner!r}, but the method is {name!r}: --set")
        fields[field] = value
    return make_method(name, **fields)


def _describe_method(point: EntryPoint) -> dict[str, Any]:
    try:
        cls = point.load()
    except (ImportError, AttributeError) as error:
        return {"about": f"cannot be loaded: {console.one_line(error)}", "fields": {}}
    about = (cls.__doc__ or "").strip().partition("\n")[0]
    known = {field.name: field.default for field in dataclasses.fields(cls) if field.init and field.name != "name"}
    return {"about": about, "fields": known}


def _input_files(*paths: Path) -> list[Path]:
    from rectmerge.mapfile import map_files

    return [file for path in paths for file in map_files(path)]


def _read_maps(
    paths: Sequence[Path], levels: dict[str, int | None], *, strict: bool, quiet: bool
) -> list[OccupancyGrid]:
    """Read the maps; say on stderr what was guessed about them."""
    from rectmerge.mapfile import is_yaml, read_image, read_map

    if all(map(is_yaml, paths)) and any(level is not None for level in levels.values()):
        raise InputError("--free, --occupied and --unknown are for plain images; a YAML tells them by its thresholds")
    grids, notes = [], []
    for path in paths:
        if is_yaml(path):
            grids.append(read_map(path, strict_thresholds=strict))
            continue
        grid, guess = read_image(path, **levels)
        grids.append(grid)
        notes.append(f"{path}: read with {guess} (--free, --occupied, --unknown say otherwise); resolution not known")
        if beside := [p for s in (".yaml", ".yml") if (p := path.with_suffix(s)).exists()]:
            notes.append(f"{path}: {beside[0].name} beside it is not read; give it instead to use what it tells")
    for note in () if quiet else notes:  # once all are read: of bad input there is one line
        console.say(note)
    return grids


def _told(found: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> dict[str, Any]:
    """Lay an answer out for ``alignment.json``, with the area that both maps show under each candidate."""
    from rectmerge.transform import SharedArea

    told = found.as_dict()
    for candidate, each in zip(found.candidates, told["candidates"], strict=True):
        each["shared"] = SharedArea.of(a, b, candidate.pixels).as_dict()
    return told


def _with_quality(found: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> Alignment:
    """Measure the maps' own accuracy where the method did not."""
    from rectmerge.quality import measure_quality

    measured = {"a": measure_quality(a).as_dict(), "b": measure_quality(b).as_dict()}
    return dataclasses.replace(found, quality=found.quality or measured)


def _certify(found: Alignment, a: OccupancyGrid, b: OccupancyGrid, scale: Scale, seconds: float) -> Certificate:
    from rectmerge.methods import searched_scale
    from rectmerge.robust.certificate import certify

    searched = searched_scale(scale, found.scale)
    return certify(a, b, found.candidates[0].pixels, scale=searched, seconds=seconds)


def _results(
    found: Alignment, a: OccupancyGrid, b: OccupancyGrid, rule: Rule
) -> tuple[dict[str, NDArray[np.uint8]], OccupancyGrid | None]:
    """Draw what is to be written, and merge the maps if the answer is yes."""
    from rectmerge.composition import compose
    from rectmerge.picture import draw_conflict, draw_overlay

    if not found:
        overlays = (draw_overlay(a, b, candidate.pixels) for candidate in found.candidates)
        return {f"overlay_{i}.png": overlay for i, overlay in enumerate(overlays, start=1)}, None
    composition = compose([a, b], [None, found.b_to_a], rule=rule)
    overlay = draw_overlay(a, b, found.candidates[0].pixels)
    return {"overlay.png": overlay, "conflict.png": draw_conflict(composition)}, composition.grid


def _describe(found: Alignment, files: Sequence[Path], certificate: Certificate | None = None) -> str:
    lines = [f"{found.verdict}: {found.reason}", f"  method      {found.method}, {found.seconds:.2f} s"]
    if found.candidates:
        if not found:
            lines.append(f"  the best guess of {len(found.candidates)}, not to be used unseen:")
        lines += _describe_candidate(found, found.candidates[0])
    if found and found.confidence < DOUBTFUL:
        lines.append("  look at     overlay.png before using the map: the method is not sure")
    if certificate is not None:
        lines.append(f"  certified   {certificate}")
    where = files[0].parent
    return "\n".join([*lines, f"  written     {where}: {', '.join(file.name for file in files)}"])


def _describe_candidate(found: Alignment, best: Candidate) -> list[str]:
    expected = found.scale.expected
    ratio = "" if expected is None else f", {expected:.4f} by the resolutions"
    turn = math.degrees(math.remainder(best.b_to_a.angle, math.tau))
    return [
        f"  confidence  {best.confidence:.2f}",
        f"  scale       {best.pixels.scale:.4f} cells of A per cell of B{ratio}",
        f"  rotation    {turn:+.2f} deg, counter-clockwise from B to A",
        f"  shift       {best.b_to_a.tx:+.2f}, {best.b_to_a.ty:+.2f} {found.unit}",
        f"  overlap     {best.overlap:.0%} of the smaller free space",
        f"  conflict    {best.conflict:.1%} of the walls that both maps see",
    ]
