"""Points and headings of a CSV carried to map A; other columns and comments stay unchanged."""

from __future__ import annotations

import csv
import io
import logging
from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

from rectmerge.errors import InputError
from rectmerge.transfer.carrier import STD_NAME, Carrier
from rectmerge.transfer.poses import (
    CARRIED,
    TURN,
    abbreviate,
    parse_finite,
    turn_headings,
    unknown_headings,
)

SEPARATORS = (",", ";", "\t")
PLACE = ("x", "y")
LOGGER = logging.getLogger("rectmerge")


class _Row(NamedTuple):
    line: int
    cells: list[str]

    def by_name(self, names: list[str]) -> dict[str, str]:
        return dict(zip(names, self.cells, strict=False))


class _Header(NamedTuple):
    """Names of the columns, the separator of cells, and whether a header line gives the names."""

    names: list[str]
    separator: str
    is_given: bool


def carry_table(text: str, carrier: Carrier) -> str:
    """Carry the columns x and y of a CSV, and headings by the column names of `rectmerge.transfer.poses`.

    Parameters
    ----------
    text
        Rows of cells, separated by commas, semicolons or tabs, below a header line; without it two columns of numbers,
        separated by commas. Lines that begin with # are comments.
    carrier
        The placement; where it bends, and there is a header line, a column with the standard deviation is added.

    Raises
    ------
    InputError
        If columns are not named, a row has no place or no heading, or there is no row.
    """
    header = _read_header(text)
    records = list(_records(text, header.separator))
    all_rows = [record for record in records if isinstance(record, _Row)]
    rows = all_rows[header.is_given :]
    if not rows:
        raise InputError("it holds no points")
    if carrier.is_bent and header.is_given:
        _add_std(all_rows[0], rows, header, carrier)
    _carry_rows(rows, header, carrier)
    written = io.StringIO()
    writer = csv.writer(written, delimiter=header.separator, lineterminator="\n")
    for record in records:
        if isinstance(record, _Row):
            writer.writerow(record.cells)
        else:
            written.write(record)
    for name in unknown_headings(header.names):
        LOGGER.warning("column %s stays as it is; if it is a heading, name it one of %s", name, ", ".join(TURN))
    return written.getvalue()


def _add_std(head: _Row, rows: list[_Row], header: _Header, carrier: Carrier) -> None:
    """Write the standard deviations of places into their column, a new last one unless there is one."""
    if STD_NAME not in header.names:
        head.cells.append(STD_NAME)
        header.names.append(STD_NAME)
    column = header.names.index(STD_NAME)
    for row in rows:
        std = carrier.std_at(_place(row, header))
        row.cells.extend([""] * (column + 1 - len(row.cells)))
        row.cells[column] = "" if std is None else f"{std:.6f}"


def _carry_rows(rows: list[_Row], header: _Header, carrier: Carrier) -> None:
    """Carry the cells of rows in place."""
    names = header.names
    before = [_place(row, header) for row in rows]
    for row, start, place in zip(rows, before, carrier.carry(before), strict=True):
        for name, number in zip(PLACE, place, strict=True):
            row.cells[names.index(name)] = f"{number:.6f}"
        try:
            turned = turn_headings(row.by_name(names), carrier.turn_at(start))
        except InputError as error:
            raise InputError(f"line {row.line}: {error}") from None
        for name, number in turned.items():
            row.cells[names.index(name)] = f"{number:.8f}"


def _place(row: _Row, header: _Header) -> list[float]:
    values = row.by_name(header.names)
    if not header.is_given and len(row.cells) > len(PLACE):
        raise _unnamed(row)
    if not values.keys() >= set(PLACE):
        raise InputError(f"line {row.line} has too few columns: {abbreviate(header.separator.join(row.cells))}")
    return [parse_finite(f"line {row.line}", values[name]) for name in PLACE]


def _read_header(text: str) -> _Header:
    """Read the first row; the separator is the one that yields the names x and y, as a guess could be wrong."""
    for separator in SEPARATORS:
        if (row := _first(text, separator)) is None:
            raise InputError("it holds no points")
        names = [cell.strip().lower() for cell in row.cells]
        if set(PLACE) <= set(names):
            if twice := [name for name in (*PLACE, *sorted(CARRIED)) if names.count(name) > 1]:
                raise InputError(f"line {row.line}: two columns are named {twice[0]}")
            return _Header(names, separator, is_given=True)
    row = _first(text, SEPARATORS[0])
    if row is None or len(row.cells) != len(PLACE) or not all(map(_is_number, row.cells)):
        raise _unnamed(row or _Row(1, []))
    return _Header(list(PLACE), SEPARATORS[0], is_given=False)


def _unnamed(row: _Row) -> InputError:
    shown = abbreviate(",".join(row.cells))
    return InputError(
        f"name the columns x and y in a header line, by commas, semicolons or tabs; line {row.line}: {shown}"
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
    """Yield rows, which may hold quoted line ends, and comments unchanged; skip empty lines."""
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
