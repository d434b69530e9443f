"""Storeys that look alike and storeys after changes: a page from a run of `storeys`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from scenarios.bench.resume import read_machine
from scenarios.bench.run import read_rows
from scenarios.scoring.markdown import markdown
from scenarios.scoring.row import Row, by_method, checked_outcome, versions_line
from scenarios.scoring.score import FAILURES
from scenarios.scoring.statistics import clustered_rate
from scenarios.studies.trust import wrong_table

SUITE = "storeys"


def write_page(run: Path, out: Path) -> None:
    """Write the page from a finished run.

    Raises
    ------
    InputError
        If the folder holds no run of the suite, or its machine.json cannot be read.
    """
    rows = [row for row in read_rows(run) if row["suite"] == SUITE]
    if not rows:
        raise InputError(f"{run}: holds no rows of {SUITE}; make it with: rectbench run {SUITE} -o RUN")
    made = read_machine(run)
    origin = f"commit {made['commit'] or 'unknown'}; {made['processor']}, {made['cores']} cores"
    replace_file(out, page(rows, origin).encode())


def page(rows: Sequence[Row], origin: str) -> str:
    """Return the page; `origin` names the run's commit and machine."""
    alike = [row for row in rows if row["stratum"] == "unrelated"]
    changed = [row for row in rows if row["stratum"] != "unrelated"]
    parts = [
        f"{INTRODUCTION}Run by {origin}.\n",
        versions_line(rows),
        "## Two storeys: never to be joined\n",
        storeys_table(alike),
        "## One storey after changes: to be joined\n",
        changes_table(changed),
        "## Every wrong answer that was accepted\n",
    ]
    for label, answers in by_method(rows).items():
        parts += [f"By `{label}`:\n", wrong_table(answers)]
    return "\n".join(parts)


def storeys_table(rows: Sequence[Row]) -> str:
    """Count the answers to pairs of two storeys, by method and in all and by family."""
    cells = []
    for label, name, part in _parts(rows):
        joined = clustered_rate([row["outcome"] == "wrong-accepted" for row in part], [row["place"] for row in part])
        checked = sum(checked_outcome(row) == "wrong-accepted" for row in part)
        cells.append((label, name, str(joined), str(checked), *_left(part)))
    return markdown(("method", "family", "joined", "checked: joined", "ambiguous", "rejected", "failed"), cells)


def changes_table(rows: Sequence[Row]) -> str:
    """Count the answers to pairs of one storey, by method and in all and by family."""
    cells = []
    for label, name, part in _parts(rows):
        right = clustered_rate([row["outcome"] == "right-accepted" for row in part], [row["place"] for row in part])
        wrong = sum(row["outcome"] == "wrong-accepted" for row in part)
        cells.append((label, name, str(right), str(wrong), *_left(part)))
    return markdown(
        ("method", "family", "right and accepted", "wrong and accepted", "ambiguous", "rejected", "failed"), cells
    )


def _parts(rows: Sequence[Row]) -> list[tuple[str, str, list[Row]]]:
    """Return the rows of each method in all and by family, with both names."""
    parts = []
    for label, answers in by_method(rows).items():
        by_family: dict[str, list[Row]] = {"all": answers}
        for row in answers:
            by_family.setdefault(str((row["info"] or {}).get("family", "not made")), []).append(row)
        parts += [(label, name, part) for name, part in by_family.items()]
    return parts


def _left(rows: Sequence[Row]) -> tuple[str, str, str]:
    """Count the answers that are ambiguous, rejected, and none."""
    outcomes = [row["outcome"] for row in rows]
    names = {
        "ambiguous": ("ambiguous-with-truth", "ambiguous-without-truth"),
        "rejected": ("rejected",),
        "failed": FAILURES,
    }
    ambiguous, rejected, failed = (str(sum(outcome in kinds for outcome in outcomes)) for kinds in names.values())
    return ambiguous, rejected, failed


INTRODUCTION = """# Storeys that look alike

Simulated pairs of the suite `storeys`: two storeys of one building, with the same outer walls, corridors and hall, and
other rooms, doors and furniture, which must not be joined; and one storey after changes, where every piece of furniture
was moved, removed or added between the visits and doors were shut or opened, which must. Both robots map 0.6 to 1 of
the rooms, at noise 0, 1 and 2 (three pairs a building), in cells of ratio 0.6 to 1.6. No weight is fitted to storeys;
that bent maps do not meet exactly, which tells most of them apart, was found on the buildings of seed 0. *Checked*:
where the judge of `rectmerge check` has the last word, as in `merge`. This page is made by

    rectbench generate storeys --seed 4711 -o sets/storeys
    rectbench run sets/storeys --method robust -o runs/storeys
    rectbench storeys runs/storeys -o results/storeys/README.md

"""
