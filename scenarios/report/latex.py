"""Leaderboards as LaTeX tables, for papers; they need the package booktabs."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.report.reading import Contest
from scenarios.report.standings import as_cells, standings

COLUMNS = ("right and accepted", "best right", "wrong", "false merges", "AURC", "ECE", "e, cells", "CPU s")
ESCAPED = str.maketrans({"%": r"\%", "_": r"\_", "&": r"\&", "#": r"\#"})


def latex(contests: Sequence[Contest]) -> str:
    """Return one table per suite and track."""
    return "\n".join(_table(contest) for contest in contests)


def _table(contest: Contest) -> str:
    lines = [(line.label, as_cells(line)) for line in standings(contest)]
    rows = [" & ".join([label, *(cells[name][0] for name in COLUMNS)]).replace("%", r"\%") for label, cells in lines]
    body = " \\\\\n    ".join(row.replace("_", r"\_").replace("#", r"\#") for row in rows)
    heads = " & ".join(("method", *COLUMNS))
    pairs = len({row["pair_id"] for row in contest.rows})
    return rf"""\begin{{table}}
  \centering
  \caption{{{contest.name.translate(ESCAPED)}: {pairs} pairs. Counts with share and 95\,\% interval by place.}}
  \begin{{tabular}}{{l{"r" * len(COLUMNS)}}}
    \toprule
    {heads} \\
    \midrule
    {body} \\
    \bottomrule
  \end{{tabular}}
\end{{table}}
"""
