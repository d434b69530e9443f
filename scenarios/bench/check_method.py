"""Check of a method on easy pairs, which names its mistake."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rectmerge.alignment import Alignment, Method
from rectmerge.grid import pixels_to_map_frame
from rectmerge.io.json_text import to_json
from scenarios.bench.asking import TimedAnswer, answer_within
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import MATRIX
from scenarios.bench.mistakes import name_mistake
from scenarios.bench.rows import score_answer
from scenarios.execution.limits import Limits
from scenarios.execution.terminal import table
from scenarios.pairs.drawn_pairs import VIEWS, easy_pairs
from scenarios.pairs.pair import MapPair
from scenarios.scoring.row import Row, is_best_right

WITHIN = Limits(timeout_s=60.0)
HEADS = ("pair", "answer", "error, cells", "turn, deg", "scale, %", "confidence", "seconds")
SAME_PLACE = 1e-6  # of `b_to_a` and `pixels` of one candidate, in units of A's map frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """An easy pair, a method's answer to it, and the answer as a row that is scored."""

    pair: MapPair
    answer: TimedAnswer
    row: Row

    @property
    def alignment(self) -> Alignment | None:
        """Return the method's answer; None where it failed."""
        return self.answer.attempt.value

    @property
    def is_right(self) -> bool:
        """Return True if the best candidate is right, whatever the verdict."""
        return is_best_right(self.row)


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodCheck:
    """Answers of a checked method, and a complaint for each fault."""

    answers: Sequence[Asked]
    complaints: Sequence[str]

    def as_text(self) -> str:
        """Return a table of the pairs, and the complaints below it."""
        lines = [f"wrong: {complaint}" for complaint in self.complaints] or ["all is well"]
        return "\n".join([table(HEADS, [_cells(asked) for asked in self.answers]), "", *lines])


def check_method(
    label: str, method: Method, *, seed: int = 0, on_answer: Callable[[str], None] = lambda pair: None
) -> MethodCheck:
    """Put a method to every easy pair, twice with the same seed, in a process of its own, and list its faults.

    Parameters
    ----------
    label
        The method's name for its author.
    method
        The method.
    seed
        Of every answer.
    on_answer
        Called after each pair with its name.
    """
    contender = Contender(label=label, method=method)
    answers, unsteady = [], []
    for pair in easy_pairs():
        first = _ask(pair, contender, seed)
        answers.append(first)
        if first.alignment is not None and _content(first) != _content(_ask(pair, contender, seed)):
            unsteady.append(pair.pair_id)
        on_answer(pair.pair_id)
    return MethodCheck(answers=answers, complaints=[*_complaints(answers), *_about_seeds(unsteady)])


def _ask(pair: MapPair, contender: Contender, seed: int) -> Asked:
    answer = answer_within(pair, contender, seed=seed, limits=WITHIN)
    return Asked(pair=pair, answer=answer, row=score_answer(pair, contender, answer))


def _content(asked: Asked) -> str:
    """Return the parts in which two answers with the same seed must agree."""
    row = asked.row
    return to_json([row["outcome"], row["verdict"], row["confidence"], row["candidates"]])


def _complaints(answers: Sequence[Asked]) -> list[str]:
    """List the faults of all answers."""
    return [
        *_about_failures(answers),
        *_about_placements(answers),
        *_about_refusals(answers),
        *_about_confidence(answers),
        *_about_frames(answers),
    ]


def _about_failures(answers: Sequence[Asked]) -> list[str]:
    reasons: dict[str, list[str]] = {}
    for asked in answers:
        if asked.alignment is None:
            reasons.setdefault(f"{asked.row['outcome']}: {asked.row['reason']}", []).append(asked.pair.pair_id)
    return [f"it fails on {_listed(pairs)}: {reason}" for reason, pairs in reasons.items()]


def _about_placements(answers: Sequence[Asked]) -> list[str]:
    placed = [(asked, np.array(candidates[0])) for asked in answers if (candidates := asked.row["candidates"])]
    mistake = name_mistake([(asked.pair, matrix) for asked, matrix in placed])
    if mistake is not None:
        return [f"{mistake.advice} ({mistake.name})"]
    off = [asked.pair.pair_id for asked, _ in placed if not asked.is_right]
    if not off:
        return []
    return [f"its best placement is wrong on {_listed(off)}, by no mistake that is known here"]


def _about_refusals(answers: Sequence[Asked]) -> list[str]:
    """Name the easy pairs that were not accepted."""
    refused = [asked.pair.pair_id for asked in answers if asked.alignment is not None and not asked.alignment]
    return [f"it does not accept {_listed(refused)}, whose maps are clean and share most of a building"] * bool(refused)


def _about_confidence(answers: Sequence[Asked]) -> list[str]:
    odd = [
        (asked.pair.pair_id, confidence)
        for asked in answers
        if (found := asked.alignment) is not None
        for confidence in (found.confidence, *(candidate.confidence for candidate in found.candidates))
        if not (0.0 <= confidence <= 1.0 or (math.isnan(confidence) and MATRIX in found.trace))  # a program may not say
    ]
    if not odd:
        return []
    pairs = list(dict.fromkeys(pair for pair, _ in odd))
    return [f"a confidence is a probability, 0..1, but it says {odd[0][1]:g} on {_listed(pairs)}"]


def _about_frames(answers: Sequence[Asked]) -> list[str]:
    """Name the pairs on which a candidate says one thing between pixels and another between map frames."""
    torn = []
    for asked in answers:
        for candidate in asked.alignment.candidates if asked.alignment is not None else ():
            meant = pixels_to_map_frame(candidate.pixels, asked.pair.a, asked.pair.b)
            if not np.allclose(meant.matrix, candidate.b_to_a.matrix, rtol=SAME_PLACE, atol=SAME_PLACE):
                torn.append(asked.pair.pair_id)
                break
    return [f"`pixels` and `b_to_a` of a candidate differ on {_listed(torn)}: make it by Candidate.from_pixels"] * bool(
        torn
    )


def _about_seeds(unsteady: Sequence[str]) -> list[str]:
    return [
        f"two calls with the same seed differ on {_listed(unsteady)}: draw from `rng` alone, and keep nothing"
    ] * bool(unsteady)


def _listed(pairs: Sequence[str]) -> str:
    return "every pair" if len(pairs) == len(VIEWS) else ", ".join(f'"{pair}"' for pair in pairs)


def _cells(asked: Asked) -> list[str]:
    """Return the table row of one pair."""
    row = asked.row
    verdict: str = row["verdict"] or row["outcome"]
    if row["candidates"]:
        verdict += ", right" if asked.is_right else ", wrong"
    errors = row["errors"]
    values = [errors["e_px"], errors["rotation_deg"], errors["scale_pct"]] if errors else []
    figures = [f"{value:.2f}" for value in values] or ["-"] * 3
    confidence = row["confidence"]
    sure = "-" if confidence is None or math.isnan(confidence) else f"{confidence:.2f}"
    return [asked.pair.pair_id, verdict, *figures, sure, f"{row['seconds']['wall']:.2f}" if row["seconds"] else "-"]
