"""The command `rectmerge transform`: an answer for TF, and points of map B on map A."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import MergeFolder
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.results.alignment_json import AnswerFile
    from rectmerge.transfer.transform import Placed

TOLD_FROM = 0.0005  # a misfit below this would be told as 0.000
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
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="Where these go.")] = None,
) -> None:
    """Print where map B lies on map A as other programs take it: as a line for TF, a matrix, or a pose x y yaw.

    The parent is the frame of map A, the child that of map B: where bags name both, and not alike, these names stand
    unless others are given. TF carries no scale: where map B is to be scaled, the transform is fitted anew without
    scale, and stderr tells by how much that misses. With --points the points of a file are carried from B's map frame
    to A's instead, scale and all: columns x and y, and headings in columns, or properties of a Point, named yaw, theta
    or heading (radians), yaw_deg, theta_deg or heading_deg, or qz and qw. A map without resolution is in cells: stderr
    says so, and there is no line for TF, which is in metres. Where the merge said no and no candidate is named, the
    status is that of the merge, 1 or 3.
    """
    from rectmerge.io.atomic_file import replace_file
    from rectmerge.results.alignment_json import AnswerFile
    from rectmerge.transfer.points import carry_points
    from rectmerge.transfer.transform import FORMS as KNOWN
    from rectmerge.transfer.transform import Answer

    known = {name: name for name in KNOWN}
    if form not in known:
        raise typer.BadParameter(f"{form!r} is not one of {FORMS}: --as")
    if output is not None and points is None:
        raise InputError("-o says where carried points go; name them with --points")
    file = AnswerFile.read(folder)
    answer = Answer.of(file)
    if candidate is None and answer.verdict != "accepted":
        count = len(answer.candidates)
        console.say(f"rectmerge: {folder}: {answer.verdict}, {answer.reason}; --candidate K takes one of its {count}")
        raise typer.Exit(console.STATUS[answer.verdict])
    placed = answer.candidate(candidate or 1)
    if points is not None:
        _refuse(output, points, file)
        told = carry_points(_text(points), points.name, placed.b_to_a)
    else:
        frame_a, frame_b = answer.named(parent, child)
        told = placed.line(known[form], parent=frame_a, child=frame_b) + "\n"
    for note in _notes(placed, has_scale=points is not None or form == "matrix"):
        console.note(f"rectmerge: {note}")
    if output is None:
        typer.echo(told, nl=False)
    else:
        replace_file(output, told.encode())


def _notes(placed: Placed, *, has_scale: bool) -> Iterator[str]:
    """Tell what numbers alone do not: that they are not in metres, and what they miss where they lack the scale."""
    if placed.in_cells:
        yield placed.in_cells
    elif placed.out_of_scale:
        yield placed.out_of_scale
    if not has_scale and placed.misfit >= TOLD_FROM:
        yield (
            f"map B fits at a scale of {placed.b_to_a.scale:.5f}, which TF cannot carry; without it the area that both"
            f" maps show is off by {placed.misfit:.3f} {placed.unit} RMS"
        )


def _refuse(output: Path | None, points: Path, answer: AnswerFile) -> None:
    """Refuse to write over what the command reads, or what the merge wrote."""
    from rectmerge.io.atomic_file import real, require_other
    from rectmerge.results.folder import ResultFolder

    if output is None:
        return
    require_other(output, [points, answer.path])
    if any(ResultFolder(folder).owns(output) for folder in (answer.folder, real(answer.path).parent)):
        raise InputError(f"{output}: is for a result of the merge; name another file with -o")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")  # spreadsheets put a mark first
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text") from None
