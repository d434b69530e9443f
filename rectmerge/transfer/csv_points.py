"""Points in a CSV, with their headings, carried to map A; other columns and comments stay as they are."""

from __future__ import annotations

import csv
import io
import logging
from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.poses import CARRIED, TURN, finite, left_alone, moved, short, turned

SEPARATORS = (",", ";", "\t")
PLACE = ("x", "y")
LOGGER = logging.getLogger("rectmerge")


class _Row(NamedTuple):
    line: int
    cells: list[str]

    def told(self, names: list[str]) -> dict[str, str]:
        return dict(zip(names, self.cells, strict=False))


class _Heading(NamedTuple):
    """What the first row says: the columns' names, by what cells are separated, and whether it is itself of names."""

    names: list[str]
    separator: str
    is_told: bool


def carry_table(text: str, b_to_a: Similarity) -> str:
    """Carry the columns x and y of a CSV, and those that tell headings by the names of `rectmerge.transfer.poses`.

    Parameters
    ----------
    text
        Rows of cells by commas, semicolons or tabs, below a heading line; without it two columns of numbers, by commas.
        Lines that begin with # are comments.
    b_to_a
        The placement.

    Raises
    ------
    InputError
        If columns are not named, a row has no place or no heading, or there is none.
    """
    heading = _heading_of(text)
    records = list(_records(text, heading.separator))
    rows = [record for record in records if isinstance(record, _Row)][heading.is_told :]
    if not rows:
        raise InputError("it holds no points")
    _carry_rows(rows, heading, b_to_a)
    written = io.StringIO()
    writer = csv.writer(written, delimiter=heading.separator, lineterminator="\n")
    for record in records:
        if isinstance(record, _Row):
            writer.writerow(record.cells)
        else:
            written.write(record)
    for name in left_alone(heading.names):
        LOGGER.warning("column %s stays as it is; if it is a heading, name it one of %s", name, ", ".join(TURN))
    return written.getvalue()


def _carry_rows(rows: list[_Row], heading: _Heading, b_to_a: Similarity) -> None:
    """Carry the cells of rows in place."""
    names = heading.names
    places = moved([_place(row, heading) for row in rows], b_to_a)
    for row, place in zip(rows, places, strict=True):
        for name, number in zip(PLACE, place, strict=True):
            row.cells[names.index(name)] = f"{number:.6f}"
        try:
            new = turned(row.told(names), b_to_a.angle)
        except InputError as error:
            raise InputError(f"line {row.line}: {error}") from None
        for name, number in new.items():
            row.cells[names.index(name)] = f"{number:.8f}"


def _place(row: _Row, heading: _Heading) -> list[float]:
    told = row.told(heading.names)
    if not heading.is_told and len(row.cells) > len(PLACE):
        raise _unnamed(row)
    if not told.keys() >= set(PLACE):
        raise InputError(f"line {row.line} has too few columns: {short(heading.separator.join(row.cells))}")
    return [finite(f"line {row.line}", told[name]) for name in PLACE]


def _heading_of(text: str) -> _Heading:
    """Read the first row; a guess at the separator would do harm, so it is the one by which x and y are named."""
    for separator in SEPARATORS:
        if (row := _first(text, separator)) is None:
            raise InputError("it holds no points")
        names = [cell.strip().lower() for cell in row.cells]
        if set(PLACE) <= set(names):
            if twice := [name for name in (*PLACE, *sorted(CARRIED)) if names.count(name) > 1]:
                raise InputError(f"line {row.line}: two columns are named {twice[0]}")
            return _Heading(names, separator, is_told=True)
    row = _first(text, SEPARATORS[0])
    if row is None or len(row.cells) != len(PLACE) or not all(map(_is_number, row.cells)):
        raise _unnamed(row or _Row(1, []))
    return _Heading(list(PLACE), SEPARATORS[0], is_told=False)


def _unnamed(row: _Row) -> InputError:
    shown = short(",".join(row.cells))
    return InputError(
        f"name the columns x and y in a heading line, by commas, semicolons or tabs; line {row.line}: {shown}"
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _first(text: str, separator: str) -> _Row | None:
    return next((record for record in _records(text, separator) if isinstance(record, _Row)), None)


def _records(text: str, separator: str) -> Iterator[_Row | str]:
    """Go through rows, which may hold quoted ends of lines, and comments as they stand; empty lines are left out."""
    lines, number = io.StringIO(text), 1
    for line in lines:
        if line.startswith("#"):
            yield line
            number += 1
            continue
        reader = csv.reader(chain([line], lines), delimiter=separator)  # takes as many lines as its row has
        cells = next(reader)
        if line.strip():
            yield _Row(number, cells)
        number += reader.line_num
