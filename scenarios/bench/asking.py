"""A method put to one pair: timed, within limits, a failure kept as a failure."""

from __future__ import annotations

import dataclasses
import functools
import os
import time
from collections.abc import Hashable
from dataclasses import dataclass
from typing import cast

from rectmerge.aligning import Scale, align
from rectmerge.alignment import Alignment, Method, Verdict
from rectmerge.grid import OccupancyGrid
from rectmerge.judging import confirm
from rectmerge.warm_up import small_building
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import PROGRAM_PEAK_MB, Program
from scenarios.execution.attempt import Attempt, attempt, peak_memory_mb, reset_peak_memory
from scenarios.execution.limits import Limits, call_within
from scenarios.pairs.pair import MapPair


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedAnswer:
    """A method's answer to one pair, or its failure, with time and memory; None where a number is unknown.

    `checked` is the verdict that `merge` would act on: the judge's on what another method accepts, else the method's.
    """

    attempt: Attempt[Alignment]
    checked: Verdict | None
    wall_s: float | None
    cpu_s: float | None
    peak_mb: float | None


def ask(pair: MapPair, contender: Contender, *, seed: int = 0) -> TimedAnswer:
    """Put a method to one pair in this process; its first call in the process, which compiles, is not timed."""
    attempt(lambda: _warm_up(cast(Hashable, contender.method)))
    answer = _timed(pair.a, pair.b, contender.method, seed, _scale_for(pair, contender))
    return _checked(pair, contender, answer, seed)


def ask_within(pair: MapPair, contender: Contender, *, seed: int = 0, limits: Limits) -> TimedAnswer:
    """Put a method to one pair as `answer_within` does, and its answer to the judge."""
    return _checked(pair, contender, answer_within(pair, contender, seed=seed, limits=limits), seed)


def answer_within(pair: MapPair, contender: Contender, *, seed: int = 0, limits: Limits) -> TimedAnswer:
    """Put a method to one pair in a child process, which takes the time and is killed where it exceeds its limits."""
    call = functools.partial(_timed, pair.a, pair.b, contender.method, seed, _scale_for(pair, contender))
    compiles = not isinstance(contender.method, Program)
    warm_up = functools.partial(_warm_up, cast(Hashable, contender.method)) if compiles else None
    result = call_within(limits, call, warm_up=warm_up)
    if result.value is not None:
        return result.value
    failure: Attempt[Alignment] = Attempt(failure=result.failure, reason=result.reason, log=result.log)
    wall_s = limits.timeout_s if result.failure == "timeout" else None
    return TimedAnswer(attempt=failure, checked=None, wall_s=wall_s, cpu_s=None, peak_mb=None)


def _scale_for(pair: MapPair, contender: Contender) -> Scale:
    """Return the pixel scale that a contender gets: the true one if it knows the scale.

    For maps of two places that is the ratio of the resolutions, and free where these are unknown.
    """
    if not contender.knows_scale:
        return "auto"
    if pair.pixels is not None:
        return pair.pixels.scale
    size_a, size_b = (pair.info.get(f"resolution_{name}") for name in "ab")
    return size_b / size_a if size_a and size_b else "free"


def _timed(a: OccupancyGrid, b: OccupancyGrid, method: Method, seed: int, scale: Scale) -> TimedAnswer:
    """Align two maps and measure time and peak memory."""
    can_measure = reset_peak_memory()
    wall, cpu = time.perf_counter(), _cpu_s()
    result = attempt(lambda: align(a, b, method=method, scale=scale, seed=seed))
    wall, cpu = time.perf_counter() - wall, _cpu_s() - cpu
    peaks = [
        result.value.trace.get(PROGRAM_PEAK_MB) if result.value else None,
        peak_memory_mb() if can_measure else None,
    ]
    peak_mb = max((peak for peak in peaks if peak), default=None)
    return TimedAnswer(attempt=result, checked=None, wall_s=wall, cpu_s=cpu, peak_mb=peak_mb)


def _checked(pair: MapPair, contender: Contender, answer: TimedAnswer, seed: int) -> TimedAnswer:
    """Put an answer to the judge, which costs the method neither time nor memory."""
    alignment = answer.attempt.value
    if alignment is None:
        return answer
    scale = _scale_for(pair, contender)
    judged = attempt(lambda: confirm(pair.a, pair.b, alignment, method=contender.method, scale=scale, seed=seed))
    return dataclasses.replace(answer, checked=None if judged.value is None else judged.value.verdict)


def _cpu_s() -> float:
    """Return the time on all cores of this process and of the programs it started, seconds."""
    used = os.times()
    return time.process_time() + used.children_user + used.children_system


@functools.cache
def _warm_up(method: Method) -> None:
    """Let a method compile and load, once per process, on a small building and its copy."""
    align(*small_building(), method=method)
