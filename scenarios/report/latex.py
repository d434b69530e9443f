"""Leaderboards as LaTeX tables, which need the package booktabs."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.report.reading import TrackResults
from scenarios.report.standings import as_cells, standings

COLUMNS = ("right and accepted", "best right", "wrong", "false merges", "AURC", "ECE", "e, cells", "CPU s")
ESCAPED = str.maketrans(
    {sign: rf"\{sign}" for sign in "%_&#${}"}
    | {"~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "\\": r"\textbackslash{}"}
)


def latex(tracks: Sequence[TrackResults]) -> str:
    """Return one table per suite and track."""
    return "\n".join(_table(track_results) for track_results in tracks)


def _table(track_results: TrackResults) -> str:
    lines = [(line.label, as_cells(line)) for line in standings(track_results)]
    rows = [[label, *(cells[name][0] for name in COLUMNS)] for label, cells in lines]
    body = " \\\\\n    ".join(" & ".join(cell.translate(ESCAPED) for cell in row) for row in rows)
    heads = " & ".join(("method", *COLUMNS))
    pairs = len({row["pair_id"] for row in track_results.rows})
    return rf"""\begin{{table}}
  \centering
  \caption{{{track_results.name.translate(ESCAPED)}: {pairs} pairs. Counts with share and 95\,\% interval by place.}}
  \begin{{tabular}}{{l{"r" * len(COLUMNS)}}}
    \toprule
    {heads} \\
    \midrule
    {body} \\
    \bottomrule
  \end{{tabular}}
\end{{table}}
"""
