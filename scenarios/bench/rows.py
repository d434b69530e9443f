"""Rows of results: the score of an answer to a pair, and the row of a pair without an answer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.elastic.unbend import unbend
from scenarios.bench.asking import TimedAnswer
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import MATRIX
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import is_bent, known_extent, rms
from scenarios.scoring.bends import BendValues
from scenarios.scoring.row import Row, empty_row
from scenarios.scoring.score import grade, measure_errors, outcome_of, stratum_of


def score_answer(pair: MapPair, contender: Contender, answer: TimedAnswer) -> Row:
    """Score an answer and return its row, without the task's id and what bending changes, which takes its time."""
    alignment, failure = answer.attempt.value, answer.attempt.failure
    extent = known_extent(pair.a) if pair.pixels else None
    residual = pair.residual_px / extent if extent and pair.residual_px is not None else None
    stratum = stratum_of(pair.related, pair.overlap)
    names = {"pair_id": pair.pair_id, "suite": pair.suite, "place": pair.place, "method": contender.label}
    row = empty_row(
        **names,
        related=pair.related,
        stratum=stratum,
        outcome=failure or "error",
        reason=answer.attempt.reason,
        log=answer.attempt.log,
    )
    row["knows_scale"] = contender.knows_scale
    row["bent"] = is_bent(residual)
    row["overlap"] = pair.overlap
    row["residual_px"], row["extent_px"] = pair.residual_px, extent
    row["seconds"] = None if answer.wall_s is None else {"cpu": answer.cpu_s, "wall": answer.wall_s}
    row["peak_mb"] = answer.peak_mb
    row["info"] = dict(pair.info)
    if alignment is not None:
        candidates = _placements(alignment)
        errors = [measure_errors(pixels, pair) for pixels in candidates] if extent else []
        grades = [grade(e, residual or 0.0) for e in errors]
        row["outcome"] = outcome_of(alignment.verdict, grades, stratum)
        row["checked_outcome"] = outcome_of(answer.checked or alignment.verdict, grades, stratum)
        row["verdict"], row["reason"] = alignment.verdict, alignment.reason
        row["confidence"] = alignment.confidence
        row["candidates"] = [pixels.tolist() for pixels in candidates]
        row["evidence"] = [dict(candidate.evidence) for candidate in alignment.candidates]
        row["errors"], row["grades"] = errors[0].as_dict() if errors else None, grades
        row["trace"] = dict(alignment.trace)
    return row


def score_answer_and_bend(pair: MapPair, contender: Contender, answer: TimedAnswer) -> Row:
    """Score an answer, and where it is accepted measure what bending B changes; return the row."""
    row, alignment = score_answer(pair, contender, answer), answer.attempt.value
    if alignment is not None and (answer.checked or alignment.verdict) == "accepted":
        row["bend"] = measure_bend(pair, alignment)
    return row


def measure_bend(pair: MapPair, alignment: Alignment) -> BendValues:
    """Bend B as `merge` does where it accepts an answer, and measure what that changes."""
    bend = unbend(pair.a, pair.b, alignment)
    walls_before, walls_after = bend.double_walls(pair.a, pair.b)
    points = pair.control_points
    return {
        "accepted": bool(bend),
        "reason": bend.reason,
        "e_px": None if points is None else rms((bend.warp or bend.pixels).apply(points[:, 2:]) - points[:, :2]),
        "double_walls_before": walls_before,
        "double_walls_after": walls_after,
    }


def _placements(alignment: Alignment) -> list[NDArray[np.float64]]:
    """Return the candidates' pixel matrices; the matrix that a program printed stays as it is, mirrored or sheared."""
    if (printed := alignment.trace.get(MATRIX)) is not None:
        return [np.asarray(printed)]
    return [candidate.pixels.matrix for candidate in alignment.candidates]
