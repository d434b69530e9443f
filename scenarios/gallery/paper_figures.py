"""Counterparts of the paper's figures 2 to 12 and Table I from our own buildings, for docs/the-papers-method.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rectmerge.io.atomic_file import replace_file
from rectmerge.paper.figures import FIGURES, draw_figures, draw_result
from rectmerge.paper.merging import Paper
from rectmerge.paper.trace import Trace, neighbours_table, passes_table, trace_method
from scenarios.execution.files import clear_folder
from scenarios.gallery.page_picture import small_png
from scenarios.pairs.pair import MapPair
from scenarios.pairs.paper_plan import simple_maps
from scenarios.suites.suite import load_suite

TABLES = ("table-1.md", "trace.md")
PRACTICAL_SEED = 0  # the first building of the suite headline
# W is an identity matrix, as in the paper's example; doors are left out, as 10 cells do in the paper's
SIMPLE = Paper(min_area_cells=60, weights=(1.0, 1.0, 1.0, 1.0, 1.0))


def write_figures(folder: str | Path, *, force: bool = False, say: Callable[[str], None]) -> list[Path]:
    """Write all figures and tables, and return their files.

    Raises
    ------
    InputError
        If the folder holds earlier ones and `force` is off.
    SimulationError
        If the mission of figure 12 fails.
    """
    out = clear_folder(folder, () if force else (*FIGURES, *TABLES), force=force)
    simple = trace_simple()
    say("two robots explore an office, for figure 12 ...")
    pair = practical_pair()
    practical = trace_method(pair.a, pair.b)
    pictures = draw_figures(simple) | {FIGURES[-1]: draw_result(practical)}
    for name, picture in pictures.items():
        replace_file(out / name, small_png(picture))
    for name, table in zip(TABLES, (neighbours_table(simple.rmaps[0]), passes_table(practical.passes)), strict=True):
        replace_file(out / name, f"{table}\n".encode())
    return [out / name for name in (*FIGURES, *TABLES)]


def trace_simple() -> Trace:
    """Trace the method on the maps of the simple environment."""
    a, b, _ = simple_maps()
    return trace_method(a, b, method=SIMPLE)


def practical_pair() -> MapPair:
    """Make the maps of figure 12: an office of the suite `headline`, without noise."""
    source = load_suite("headline").missions()[PRACTICAL_SEED]
    mission = replace(source.scenario.mission, rays="compiled")
    return next(replace(source, scenario=replace(source.scenario, noise=(0,), mission=mission)).pairs())
