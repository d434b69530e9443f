"""Terminal output of `rectbench`: progress, and tables as plain text."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Protocol

from rectmerge.cli import console

if TYPE_CHECKING:
    from scenarios.scoring.row import Row

LARGE_BYTES = 50_000_000  # a file that takes more than a second or two to read
SPEED_OVER_S = 600.0  # a mission takes its time: what is left is guessed from the last minutes


class Advance(Protocol):
    """Callback of a progress bar: a count, and a word to show; `before` marks the count of an earlier command."""

    def __call__(self, count: int, word: str, *, before: bool = False) -> None:
        """Count it in."""


LEGEND = """
right: accepted and right, k (rate, 95 % interval by place). wrong: accepted
though wrong; of unrelated pairs, false merges. unsure: ambiguous, with / without
the truth among the first five. no: rejected. checked: right / wrong where the
judge of `rectmerge check` has the last word, as `merge` acts. fail: error, timeout, out of memory.
e: median error in cells of A over all n, a row without candidate counting as
worst; e right: of those right. bent pairs are in the other strata too, and so are
identifiable ones, whose truth no other placement comes near in the exact building,
and unidentifiable ones, on which ambiguous is the right answer."""


@contextmanager
def progress(total: int) -> Iterator[Advance]:
    """Show count, speed and remaining time on stderr if that is a terminal."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    screen = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"))
    times = (TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    off = console.is_quiet() or not screen.is_terminal
    with Progress(*columns, *times, console=screen, disable=off, speed_estimate_period=SPEED_OVER_S) as bars:
        task = bars.add_task("starting", total=total, rate="")

        def advance(count: int, word: str, *, before: bool = False) -> None:
            if before:
                bars.reset(task, completed=count, description=word)
                return
            speed = bars.tasks[0].speed
            rate = "" if speed is None else f"{60 * speed:.3g}/min"
            bars.update(task, advance=count, description=word, rate=rate)

        yield advance


def open_with_progress(path: Path) -> AbstractContextManager[BinaryIO]:
    """Open a file; where it is large and stderr is a terminal, show there how far it is read.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    import rich.progress
    from rich.console import Console

    screen = Console(stderr=True)
    if console.is_quiet() or not screen.is_terminal or path.stat().st_size < LARGE_BYTES:
        return path.open("rb")
    return rich.progress.open(path, "rb", description=f"reading {path.parent.name}", console=screen, transient=True)


def resume_callback(advance: Advance, total: int) -> Callable[[int], None]:
    """Return a callback that announces the rows of an earlier command."""

    def on_start(done: int) -> None:
        if done:
            what = "nothing is left to do" if done >= total else f"going on after {done} of {total} rows"
            console.note(f"rectbench: {what}")
            advance(done, "going on", before=True)

    return on_start


def row_callback(advance: Advance) -> Callable[[Sequence[Row]], None]:
    """Return a callback that counts rows, and those that are right, into a progress."""
    right = 0

    def on_rows(rows: Sequence[Row]) -> None:
        nonlocal right
        right += sum(row["outcome"] == "right-accepted" for row in rows)
        advance(len(rows), f"{right} right")

    return on_rows


def summary_table(summary: Mapping[str, Any]) -> str:
    """Format a run's summary, one line per method and stratum, with its legend."""
    rows = []
    for method, strata in summary["methods"].items():
        rows.append([method])
        rows += [[f"  {name}", *_cells(name, part)] for name, part in strata.items()]
    heads = ["", "n", "right", "wrong", "unsure", "no", "checked", "fail", "e", "e right", "s"]
    return f"{table(heads, rows)}\n{LEGEND}"


def _cells(stratum: str, part: Mapping[str, Any]) -> list[str]:
    outcomes, right, checked = part["outcomes"], part["right_accepted"], part["checked_outcomes"]
    rate = f"{100 * right['rate']:.0f} %, {100 * right['low']:.0f}-{100 * right['high']:.0f}"
    failed = sum(outcomes.get(name, 0) for name in ("error", "timeout", "out-of-memory"))
    return [
        str(part["n"]),
        "-" if stratum == "unrelated" else f"{right['k']} ({rate})",
        str(outcomes.get("wrong-accepted", 0)),
        f"{outcomes.get('ambiguous-with-truth', 0)} / {outcomes.get('ambiguous-without-truth', 0)}",
        str(outcomes.get("rejected", 0)),
        f"{checked.get('right-accepted', 0)} / {checked.get('wrong-accepted', 0)}",
        str(failed),
        *("-" if part[key] is None else f"{part[key]:.2f}" for key in ("median_e_px", "median_e_px_right")),
        "-" if part["median_wall_s"] is None else f"{part['median_wall_s']:.2f}",
    ]


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Format a table as plain text, the same on a terminal and in a file."""
    full = [heads, *([*row, *[""] * (len(heads) - len(row))] for row in rows)]
    widths = [max(len(row[column]) for row in full) for column in range(len(heads))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in full]
    return "\n".join([lines[0], "-" * max(map(len, lines)), *lines[1:]])
