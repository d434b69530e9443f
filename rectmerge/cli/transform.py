"""Command `rectmerge transform`: an alignment for TF, and points of map B on map A."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import MergeFolder
from rectmerge.cli.placement_options import parse_point
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.elastic.transform import BentTransform
    from rectmerge.fleet.record import FleetFile, SavedPlacement
    from rectmerge.similarity import Similarity
    from rectmerge.transfer.transform import Form, Transform

MIN_MISFIT = 0.0005  # a smaller misfit would be printed as 0.000
FORMS = "ros1, ros2, matrix or pose"


def transform(
    folder: MergeFolder,
    form: Annotated[str, typer.Option("--as", metavar="FORM", help=f"One of {FORMS}.")] = "ros2",
    candidate: Annotated[
        int | None, typer.Option(min=1, metavar="K", help="A candidate, 1 the best, where none is accepted.")
    ] = None,
    name: Annotated[
        str | None, typer.Option("--map", metavar="NAME", help="Of more than two maps, the one in place of map B.")
    ] = None,
    parent: Annotated[
        str | None, typer.Option(metavar="FRAME", help="The frame of map A; else its bag's, else map_a.")
    ] = None,
    child: Annotated[
        str | None, typer.Option(metavar="FRAME", help="The frame of map B; else its bag's, else map_b.")
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Points of map B, to be carried to map A: CSV, GeoJSON or nav2's YAML."),
    ] = None,
    trajectory: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Trajectory of map B, TUM's form, to be carried to map A.")
    ] = None,
    at: Annotated[
        str | None, typer.Option(metavar="X,Y", help="A point of map B, at which the transform is to be right.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="File for the carried points or trajectory.")
    ] = None,
) -> None:
    """Print the transform from map B to map A as other programs take it: a line for TF, a matrix, or a pose x y yaw.

    The parent is the frame of map A, the child that of map B: where bags give both different names, these are the
    defaults. TF carries no scale: where map B has one, the transform is fitted again without scale, and its error goes
    to stderr. With --points the points of a file are carried from B's map frame to A's instead, with the scale: columns
    x and y, and headings in columns, or properties of a Point, named yaw, theta or heading (radians), yaw_deg,
    theta_deg or heading_deg, or qz and qw; with --trajectory the poses of a trajectory. A map without resolution is in
    cells: a note on stderr names it, and there is no line for TF, which is in metres. Where the merge accepted nothing
    and no candidate is given, the status is that of the merge, 1 or 3.

    Where the merge has bent map B, points are carried by the bend, and headings by the turn at their place; a CSV gets
    a column bend_std, their standard deviation, empty where the bend was not fitted. No one transform fits then: --at
    gives the one that is right at a point of map B.

    Of a merge of more than two maps there is a line for each map but the references, whose frames are the parents; with
    --map, of this map alone, whose points, trajectory and --at are then carried to its reference.
    """
    from rectmerge.fleet.record import FleetFile

    options = _Options(_form(form), name, candidate, parent, child, points, trajectory, at, output)
    options.check()
    if (fleet := FleetFile.find(folder)) is not None:
        _print_fleet(FleetFile.read(fleet), options)
    else:
        _print_pair(folder, options)


@dataclass(frozen=True)
class _Options:
    """Options of the command."""

    form: Form
    name: str | None
    candidate: int | None
    parent: str | None
    child: str | None
    points: Path | None
    trajectory: Path | None
    at: str | None
    output: Path | None

    @property
    def carried(self) -> Path | None:
        """File whose points or poses are carried to map A."""
        return self.points or self.trajectory

    @property
    def place(self) -> tuple[float, float] | None:
        """Point of map B at which the transform is to be right."""
        return None if self.at is None else parse_point(self.at)

    def check(self) -> None:
        """Refuse options that contradict each other, before any file is read."""
        if self.output is not None and self.carried is None:
            raise InputError("-o names the file for carried points; give them with --points or --trajectory")
        given = {"--at": self.place, "--points": self.points, "--trajectory": self.trajectory}
        if len(exclusive := [name for name, value in given.items() if value is not None]) > 1:
            raise InputError(f"{' and '.join(exclusive)} exclude each other")


def _form(name: str) -> Form:
    from rectmerge.transfer.transform import FORMS as KNOWN

    known = {form: form for form in KNOWN}
    if name not in known:
        raise InputError(f"--as: {name!r} is not one of {FORMS}")
    return known[name]


def _print_pair(folder: Path, options: _Options) -> None:
    """Print the transform of a merge of two maps, or carry points or a trajectory through it."""
    from rectmerge.results.alignment_json import AlignmentFile
    from rectmerge.results.saved_alignment import SavedAlignment
    from rectmerge.results.saved_bend import read_bend

    if options.name is not None:
        raise InputError(f"{folder}: holds two maps; --map is for more")
    file = AlignmentFile.read(folder)
    alignment = SavedAlignment.from_file(file)
    if options.candidate is None and alignment.verdict != "accepted":
        verdict, count = f"{alignment.verdict}, {alignment.reason}", len(alignment.candidates)
        console.say(f"rectmerge: {folder}: {verdict}; --candidate K takes one of its {count}")
        raise typer.Exit(console.STATUS[alignment.verdict])
    placement = alignment.candidate(options.candidate or 1)
    bend = read_bend(file) if options.candidate in (None, 1) else None
    if options.carried is not None:
        _carry(options.carried, options, file.path, placement.b_to_a if bend is None else bend)
        _note(_notes(placement, has_scale=True))
        return
    if options.place is not None:
        placement = placement.at(options.place, bend)
    frame_a, frame_b = alignment.frame_names(options.parent, options.child)
    text = placement.format(options.form, parent=frame_a, child=frame_b)
    _note(_notes(placement, has_scale=options.form == "matrix"))
    if bend is not None and options.place is None:
        with file.explain_errors():
            moved = file.record["unbent"]["largest_move"] * bend.cell_size
        _note([_bent_by("map B", f"{moved:.3g} {bend.unit}")])
    console.tell(text)


def _bent_by(name: str, moved: str) -> str:
    at = "--at X,Y gives the one that is right at a point of it"
    return f"{name} was bent by up to {moved}, which one transform cannot carry; {at}"


def _carry(carried: Path, options: _Options, record: Path, through: Similarity | BentTransform) -> None:
    """Carry the points or the trajectory of a file to map A, and print or write them."""
    from rectmerge.io.atomic_file import replace_file
    from rectmerge.transfer.points import carry_points
    from rectmerge.transfer.trajectory import carry_trajectory

    _refuse(options.output, carried, record)
    carry = carry_points if options.trajectory is None else carry_trajectory
    text = carry(_text(carried), carried.name, through)
    if options.output is None:
        console.tell(text, ends_line=False)
    else:
        replace_file(options.output, text.encode())


def _print_fleet(file: FleetFile, options: _Options) -> None:
    """Print the transforms of a merge of more than two maps, a line or a matrix each."""
    form, parent, folder = options.form, options.parent, file.path.parent
    if options.candidate is not None or options.child is not None:
        raise InputError(f"{folder}: holds more than two maps; --candidate and --child are for two")
    if options.name is None and (options.carried is not None or options.at is not None):
        raise InputError(f"{folder}: holds more than two maps; --map says whose points they are")
    if not file.placements:
        console.say(f"rectmerge: {folder}: no maps belong together")
        raise typer.Exit(console.NO)
    placements = file.placements if options.name is None else (file.placement(options.name),)
    _require_metres(placements, is_tf=options.carried is None and form in ("ros1", "ros2"))
    if options.carried is not None:
        (placement,) = placements
        _carry(options.carried, options, file.path, file.bend(placement.name) or placement.transform.b_to_a)
        return
    if parent is not None and len({placement.reference for placement in placements}) > 1:
        raise InputError(f"{folder}: has more than one component, so --parent cannot name all their frames")
    for placement in placements:
        if options.place is None:
            _print_placed(placement, placement.transform, options)
        else:
            there = placement.transform.at(options.place, file.bend(placement.name))
            _print_placed(replace(placement, largest_move=0.0), there, options)


def _print_placed(placement: SavedPlacement, transform: Transform, options: _Options) -> None:
    """Print the transform of one map of many."""
    form, (a, b) = options.form, placement.frame_names(options.parent)
    if form != "matrix" and transform.scale_fault:
        scale = f"{placement.name} fits {a} at a scale of {transform.b_to_a.scale:.3g}"
        raise InputError(f"{scale}, so a resolution is wrong: correct it and merge again, or --as matrix keeps it")
    if placement.largest_move:
        _note([_bent_by(placement.name, f"{placement.largest_move:.0f} cells") + f" with --map {placement.name}"])
    heads = {"matrix": f"# {b} in {a}\n", "pose": f"{b} "}
    console.tell(heads.get(form, "") + transform.format(form, parent=a, child=b))
    misfit = 0.0 if form == "matrix" else transform.misfit
    if misfit >= MIN_MISFIT:
        scale = f"{placement.name} fits at a scale of {transform.b_to_a.scale:.5f}, which TF cannot carry"
        _note([f"{scale}; without it its free space is off by {misfit:.3f} {transform.unit} RMS"])


def _require_metres(placements: Iterable[SavedPlacement], *, is_tf: bool) -> None:
    """Refuse TF for maps in cells, and note them for all else."""
    cells = [one.name for one in placements if one.transform.unit != "m" or one.transform.shared.unit != "m"]
    if not cells:
        return
    fault = (
        f"the placement of {', '.join(cells)} is in cells; give every map a YAML with its resolution and merge again"
    )
    if is_tf:
        raise InputError(f"TF is in metres, but {fault}")
    console.note(f"rectmerge: {fault}")


def _note(lines: Iterable[str]) -> None:
    for line in lines:
        console.note(f"rectmerge: {line}")


def _notes(placement: Transform, *, has_scale: bool) -> Iterator[str]:
    """Yield warnings on numbers that are not in metres, or that miss because they lack the scale."""
    if placement.unit_fault:
        yield placement.unit_fault
    elif placement.scale_fault:
        yield placement.scale_fault
    if not has_scale and placement.misfit >= MIN_MISFIT:
        yield (
            f"map B fits at a scale of {placement.b_to_a.scale:.5f}, which TF cannot carry; without it the area that"
            f" both maps show is off by {placement.misfit:.3f} {placement.unit} RMS"
        )


def _refuse(output: Path | None, points: Path, record: Path) -> None:
    """Refuse to write over the inputs of the command, or the maps and the results of the merge."""
    from rectmerge.cli.map_options import input_files
    from rectmerge.io.atomic_file import require_other, resolve_links
    from rectmerge.results.folder import ResultFolder
    from rectmerge.results.inputs import recorded_inputs

    if output is None:
        return
    require_other(output, [points, record, *input_files(recorded_inputs(record))])
    if any(ResultFolder(folder).owns(output) for folder in (record.parent, resolve_links(record).parent)):
        raise InputError(f"{output}: is for a result of the merge; name another file with -o")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")  # spreadsheets write a byte order mark
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text") from None
