"""Command `rectmerge transform`: an alignment for TF, and points of map B on map A."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import MergeFolder
from rectmerge.cli.placement_options import parse_point
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.fleet.record import FleetFile
    from rectmerge.results.alignment_json import AlignmentFile
    from rectmerge.transfer.transform import Form, Transform

MIN_MISFIT = 0.0005  # a smaller misfit would be printed as 0.000
FORMS = "ros1, ros2, matrix or pose"


def transform(
    folder: MergeFolder,
    form: Annotated[str, typer.Option("--as", metavar="FORM", help=f"One of {FORMS}.")] = "ros2",
    candidate: Annotated[
        int | None, typer.Option(min=1, metavar="K", help="A candidate, 1 the best, where none is accepted.")
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

    Of a merge of more than two maps there is a line for each map but the references, whose frames are the parents.
    """
    from rectmerge.fleet.record import FleetFile
    from rectmerge.io.atomic_file import replace_file
    from rectmerge.results.alignment_json import AlignmentFile
    from rectmerge.results.saved_alignment import SavedAlignment
    from rectmerge.results.saved_bend import read_bend
    from rectmerge.transfer.points import carry_points
    from rectmerge.transfer.trajectory import carry_trajectory
    from rectmerge.transfer.transform import FORMS as KNOWN

    known = {name: name for name in KNOWN}
    if form not in known:
        raise InputError(f"--as: {form!r} is not one of {FORMS}")
    carried = points or trajectory
    if output is not None and carried is None:
        raise InputError("-o names the file for carried points; give them with --points or --trajectory")
    given = {"--at": at, "--points": points, "--trajectory": trajectory}
    if len(exclusive := [name for name, value in given.items() if value is not None]) > 1:
        raise InputError(f"{' and '.join(exclusive)} exclude each other")
    place = None if at is None else parse_point(at)
    if (fleet := FleetFile.find(folder)) is not None:
        _print_fleet(FleetFile.read(fleet), known[form], parent, (candidate, child, points, trajectory, at))
        return
    file = AlignmentFile.read(folder)
    alignment = SavedAlignment.from_file(file)
    if candidate is None and alignment.verdict != "accepted":
        verdict, count = f"{alignment.verdict}, {alignment.reason}", len(alignment.candidates)
        console.say(f"rectmerge: {folder}: {verdict}; --candidate K takes one of its {count}")
        raise typer.Exit(console.STATUS[alignment.verdict])
    placement = alignment.candidate(candidate or 1)
    bend = read_bend(file) if candidate in (None, 1) else None
    if place is not None:
        placement = placement.at(place, bend)
    if carried is not None:
        _refuse(output, carried, file)
        carry = carry_points if trajectory is None else carry_trajectory
        text = carry(_text(carried), carried.name, placement.b_to_a if bend is None else bend)
    else:
        frame_a, frame_b = alignment.frame_names(parent, child)
        text = placement.format(known[form], parent=frame_a, child=frame_b) + "\n"
    for note in _notes(placement, has_scale=carried is not None or form == "matrix"):
        console.note(f"rectmerge: {note}")
    if bend is not None and carried is None and place is None:
        moved = file.record["unbent"]["largest_move"] * bend.cell_size
        console.note(
            f"rectmerge: map B was bent by up to {moved:.3g} {bend.unit}, which one transform cannot carry; "
            "--at X,Y gives the one that is right at a point of map B"
        )
    if output is None:
        console.tell(text, ends_line=False)
    else:
        replace_file(output, text.encode())


def _print_fleet(file: FleetFile, form: Form, parent: str | None, refused: tuple[object, ...]) -> None:
    """Print the transforms of a merge of more than two maps, a line or a matrix each."""
    if any(option is not None for option in refused):
        raise InputError(
            f"{file.path.parent}: holds more than two maps; --candidate, --child, --points and --at are for two"
        )
    if not file.placements:
        console.say(f"rectmerge: {file.path.parent}: no maps belong together")
        raise typer.Exit(console.NO)
    if parent is not None and len({placement.reference for placement in file.placements}) > 1:
        raise InputError(f"{file.path.parent}: has more than one component, so --parent cannot name all their frames")
    _require_metres(file, form)
    for placement in file.placements:
        a, b = placement.frame_names(parent)
        if form != "matrix" and placement.transform.scale_fault:
            scale = f"{placement.name} fits {a} at a scale of {placement.transform.b_to_a.scale:.3g}"
            raise InputError(f"{scale}, so a resolution is wrong: correct it and merge again, or --as matrix keeps it")
        text = placement.transform.format(form, parent=a, child=b)
        heads = {"matrix": f"# {b} in {a}\n", "pose": f"{b} "}
        console.tell(heads.get(form, "") + text)
        misfit = 0.0 if form == "matrix" else placement.transform.misfit
        if misfit >= MIN_MISFIT:
            scale = f"{placement.name} fits at a scale of {placement.transform.b_to_a.scale:.5f}, which TF cannot carry"
            error = f"without it its free space is off by {misfit:.3f} {placement.transform.unit} RMS"
            console.note(f"rectmerge: {scale}; {error}")


def _require_metres(file: FleetFile, form: Form) -> None:
    """Refuse TF for maps in cells, and note them for other forms."""
    cells = [one.name for one in file.placements if one.transform.unit != "m" or one.transform.shared.unit != "m"]
    if not cells:
        return
    fault = (
        f"the placement of {', '.join(cells)} is in cells; give every map a YAML with its resolution and merge again"
    )
    if form in ("ros1", "ros2"):
        raise InputError(f"TF is in metres, but {fault}")
    console.note(f"rectmerge: {fault}")


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


def _refuse(output: Path | None, points: Path, file: AlignmentFile) -> None:
    """Refuse to write over the inputs of the command or the results of the merge."""
    from rectmerge.io.atomic_file import require_other, resolve_links
    from rectmerge.results.folder import ResultFolder

    if output is None:
        return
    require_other(output, [points, file.path])
    if any(ResultFolder(folder).owns(output) for folder in (file.folder, resolve_links(file.path).parent)):
        raise InputError(f"{output}: is for a result of the merge; name another file with -o")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")  # spreadsheets write a byte order mark
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text") from None
