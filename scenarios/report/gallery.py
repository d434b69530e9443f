"""Gallery: small pictures of every pair's maps, and every answer as a matrix by which the browser lays B on A."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rectmerge.view.pictures import draw_pair
from scenarios.report.reading import Runs, TrackResults
from scenarios.scoring.row import Row

SIDE = 160  # pixels of the pictures, at the most: a report of thousands of pairs stays under 10 MB
WORST = ("wrong-accepted", "error", "timeout", "out-of-memory", "rejected", "ambiguous-without-truth")


def gallery(runs: Runs) -> dict[str, Any]:
    """Return the content of the gallery as plain data, for the page's script.

    Returns
    -------
    dict
        ``pairs``: by id, both pictures as data addresses, their sizes, the transforms from their pixels to the maps',
        the true matrix or None, and attributes of the pair. ``answers``: worst first, each of a pair, a track and
        a method, with its matrix between the maps' pixels or None.
    """
    shrunk: dict[str, Any] = {}
    answers: list[tuple[tuple[float, ...], dict[str, Any]]] = []
    for track_results in runs.tracks:
        for row in track_results.rows:
            if row["pair_id"] in runs.maps:
                shrunk.setdefault(row["pair_id"], row)
                answers.append((_badness(row), _answer(track_results, row)))
    pairs = {pair_id: _pair(runs, row) for pair_id, row in shrunk.items()}
    return {"pairs": pairs, "answers": [answer for _, answer in sorted(answers, key=lambda answer: answer[0])]}


def _badness(row: Row) -> tuple[float, ...]:
    """Return a sort key, worst first: wrong and accepted by error, then failed, missed, and the rest."""
    place = WORST.index(row["outcome"]) if row["outcome"] in WORST else len(WORST)
    if row["stratum"] == "unrelated" and row["outcome"] != "wrong-accepted":
        place = len(WORST) + 1
    return place, -float(row["errors"]["e_over_l"] if row["errors"] else 0.0)


def _answer(track_results: TrackResults, row: Row) -> dict[str, Any]:
    errors = row["errors"]
    return {
        "pair": row["pair_id"],
        "suite": track_results.name,
        "method": row["method"],
        "outcome": row["outcome"],
        "matrix": _matrix(row["candidates"][0]) if row["candidates"] else None,
        "confidence": _rounded(row["confidence"], 4),
        "e": errors and _rounded(errors["e_px"], 3),
        "eL": errors and _rounded(errors["e_over_l"], 5),
        "reason": row["reason"] or "",
    }


def _pair(runs: Runs, row: Row) -> dict[str, Any]:
    pair = runs.maps[row["pair_id"]].row().pair()
    info = row["info"] or {}
    attributes: Mapping[str, Any] = {"overlap": row["overlap"], **{key: info.get(key) for key in ("family", "noise")}}
    return {
        **draw_pair(pair.a, pair.b, SIDE),
        "truth": None if pair.pixels is None else _matrix(pair.pixels.matrix),
        "about": {key: value for key, value in attributes.items() if value is not None},
    }


def _matrix(matrix: ArrayLike) -> list[float]:
    """Return a matrix between pixels row by row, exact to a hundredth of a pixel."""
    (a, b, tx), (c, d, ty) = np.asarray(matrix, np.float64).tolist()
    return [round(a, 6), round(b, 6), round(tx, 2), round(c, 6), round(d, 6), round(ty, 2)]


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)
