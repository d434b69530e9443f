"""Page of finished runs: one file with its style, script, charts and maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.extras import require_extras
from rectmerge.io.atomic_file import replace_file
from rectmerge.view.embedding import as_gzip, package_text
from scenarios.report import charts, difficulty, merged_quality
from scenarios.report.bends import bend_cells
from scenarios.report.gallery import gallery
from scenarios.report.latex import latex
from scenarios.report.reading import Runs, TrackResults
from scenarios.report.standings import as_cells, standings, tie

PACKAGE = "scenarios.report"
TEMPLATE, STYLE, SCRIPT = "page.html.j2", "page.css", "page.js"


def write_report(folders: Sequence[Path], out: Path, *, table: Path | None = None, force: bool = False) -> int:
    """Write the report of finished runs.

    Parameters
    ----------
    folders
        Folders of the runs.
    out
        File of the page.
    table
        File for the leaderboards as LaTeX tables, or None.
    force
        Replace existing files.

    Returns
    -------
    int
        Number of answers on the page.

    Raises
    ------
    InputError
        If a run cannot be read, or a file exists and `force` is off.
    """
    for path in (out, table):
        if path is not None and path.exists() and not force:
            raise InputError(f"{path}: is there already; --force replaces it")
    runs = Runs.read(folders)
    replace_file(out, html(runs).encode())
    if table is not None:
        replace_file(table, latex(runs.tracks).encode())
    return sum(len(track_results.rows) for track_results in runs.tracks)


def html(runs: Runs) -> str:
    """Return the page of runs."""
    require_extras("jinja2", "matplotlib")
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    pair_gallery = gallery(runs)
    return environment.from_string(package_text(TEMPLATE, PACKAGE)).render(
        style=package_text(STYLE, PACKAGE),
        script=package_text("widget.js") + package_text(SCRIPT, PACKAGE),
        tracks=[_section(track_results, runs) for track_results in runs.tracks],
        provenance=runs.provenance,
        answers=len(pair_gallery["answers"]),
        gallery=as_gzip(pair_gallery),
    )


def _section(track_results: TrackResults, runs: Runs) -> dict[str, Any]:
    """Return the content of the section of one suite and track."""
    lines = standings(track_results)
    shown = charts.shown_lines(track_results, lines)
    first = difficulty.leaders(track_results)
    return {
        "name": track_results.name,
        "pairs": len({row["pair_id"] for row in track_results.rows}),
        "places": len({row["place"] for row in track_results.rows}),
        "lines": [(line.label, as_cells(line)) for line in lines],
        "tie": tie(lines),
        "shown": list(shown),
        "merged": merged_quality.as_cells(merged_quality.qualities(shown, runs.maps)),
        "first": difficulty.leaders_map(first) if first else None,
        "first_line": difficulty.leaders_line(first) if first else "",
        "heat_maps": difficulty.heat_maps(track_results),
        "bends": bend_cells(track_results.by_method()),
        "success": charts.success_charts(shown),
        "recall": charts.recall_chart(shown),
        "time": charts.time_chart(lines),
        "risk": charts.risk_chart(shown),
        "reliability": charts.reliability_chart(shown),
    }
