"""Reasons for the status of a pair, and for each map that is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from rectmerge.alignment import Alignment
from rectmerge.fleet.graph import PairAnswer, Status


def of_agreeing(alignment: Alignment, candidate: int) -> PairAnswer:
    """Answer for a pair whose candidate, 1 being the best, agrees with the graph."""
    if alignment and candidate == 1:
        return PairAnswer(status="used", reason=alignment.reason, alignment=alignment, candidate=candidate)
    reason = f"candidate {candidate} agrees with the other pairs; alone the pair is {_said(alignment)}"
    return PairAnswer(status="promoted", reason=reason, alignment=alignment, candidate=candidate)


def of_disagreeing(alignment: Alignment, overlap: float | None, *, is_joined: bool) -> PairAnswer:
    """Answer for a pair of which no candidate agrees with the graph.

    Parameters
    ----------
    alignment
        Answer of the pair.
    overlap
        Of the maps where the graph has them; None where they are in two components.
    is_joined
        Whether either map is in a component.
    """
    if overlap is not None:
        where = f"the other pairs place the maps elsewhere, with an overlap of {overlap:.2f}"
        status: Status = "thrown out" if alignment else "unrelated"
        return PairAnswer(status=status, reason=f"{where}; alone the pair is {_said(alignment)}", alignment=alignment)
    if alignment:
        status = "thrown out" if is_joined else "undecided"
        by = "other pairs, or walls of one map on the floor of another"
        reason = f"{by}, contradict it; alone the pair is {_said(alignment)}"
        return PairAnswer(status=status, reason=reason, alignment=alignment)
    status = "undecided" if alignment.verdict == "ambiguous" else "unrelated"
    return PairAnswer(status=status, reason=alignment.reason, alignment=alignment)


def of_left_out(name: str, pairs: Mapping[tuple[str, str], PairAnswer], count: int, *, is_spent: bool) -> str:
    """Return why a map is in no component.

    Parameters
    ----------
    name
        Of the map.
    pairs
        Its asked pairs.
    count
        Number of other maps.
    is_spent
        Whether pairs were not asked because the budget was spent.
    """
    by_status: dict[str, list[tuple[str, str]]] = {}
    for pair, answer in pairs.items():
        by_status.setdefault(answer.status, []).append(pair)

    def best(status: str) -> tuple[str, PairAnswer]:
        pair = max(by_status[status], key=lambda pair: _confidence(pairs[pair]))
        answer = pairs[pair]
        told = answer.reason.replace("map A", pair[0]).replace("map B", pair[1])
        return pair[1] if pair[0] == name else pair[0], replace(answer, reason=told)

    more = ""
    if is_spent:
        more = f"; only {len(pairs)} of its {count} pairs were asked: allow more"
    if "thrown out" in by_status:
        other, answer = best("thrown out")
        return f"it fits {other} alone (confidence {_confidence(answer):.2f}), but other maps contradict that{more}"
    if "undecided" in by_status:
        other, answer = best("undecided")
        return f"it may belong to {other}: {answer.reason}{more}"
    if "unrelated" in by_status:
        other, answer = best("unrelated")
        return f"it fits none of the {len(pairs)} it was compared with; the best, {other}: {answer.reason}{more}"
    return f"it was compared with no other map{more}" if more else "no other map can be used"


def _confidence(answer: PairAnswer) -> float:
    return 0.0 if answer.alignment is None else answer.alignment.confidence


def _said(alignment: Alignment) -> str:
    return f"{alignment.verdict} ({alignment.reason})"
