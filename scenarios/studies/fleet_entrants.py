"""Entrants of a fleet: the joint answer, and what peers do, a spanning tree of the pairs that a method accepts.

Peers such as `multirobot_map_merge` (J. Horner, 2016) chain the accepted pairs, the most confident first.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rectmerge.aligning import align
from rectmerge.alignment import Alignment, Candidate, Method
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.fleet.many import align_many
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import make_method
from rectmerge.similarity import Similarity
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import known_extent
from scenarios.scoring.score import grade, measure_errors

Pair = tuple[str, str]
LIE_SHARE = 0.1  # of a fleet's pairs
LIE_LOG_ODDS = 7.0  # of a wrong placement, as sure as the surest right ones
SHIFTS = (0.3, 0.7)  # of the other map's size, between which a made-up placement lays the middle of a map


@dataclass(frozen=True, slots=True, kw_only=True)
class Joined:
    """Maps that an entrant joined.

    Parameters
    ----------
    components
        Names of the maps of each.
    pixels
        From each joined map's pixels to those of its component's frame.
    answers
        Answers of the asked pairs.
    bridges
        Joins that are named as resting on one pair.
    used
        Pairs that the placements rest on, accepted alone.
    seconds
        CPU time beside that of the pairs.
    """

    components: Sequence[Sequence[str]]
    pixels: Mapping[str, Similarity]
    answers: Mapping[Pair, Alignment]
    bridges: Sequence[Pair] = ()
    used: Sequence[Pair] = ()
    seconds: float = 0.0


@dataclass(slots=True)
class Remembered:
    """Method whose answers to the maps of one fleet are kept, so that entrants may ask the same pair.

    Parameters
    ----------
    method
        The method.
    maps
        The maps by name; the very objects that it is asked about.
    lies
        Placements of B on A that it is sure of, whatever the method says.
    """

    method: Method
    maps: Mapping[str, OccupancyGrid]
    lies: dict[Pair, Similarity] = field(default_factory=dict)
    seconds: float = 0.0
    _known: dict[tuple[Pair, tuple[float, float]], Alignment] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The method's."""
        return self.method.name

    def telling(self, lies: Mapping[Pair, Similarity]) -> Remembered:
        """Return the same memory with lies."""
        return dataclasses.replace(self, lies=dict(lies))

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Answer as the method does, or once did."""
        names = {id(grid): name for name, grid in self.maps.items()}
        pair = names[id(a)], names[id(b)]
        if (pair, scale) not in self._known:
            started = time.process_time()
            self._known[pair, scale] = self.method.align(a, b, scale=scale, rng=rng)
            self.seconds += time.process_time() - started
        answer = self._known[pair, scale]
        return _with_lie(answer, self.lies[pair], a, b) if pair in self.lies else answer


def ask_all(method: Remembered) -> dict[Pair, Alignment]:
    """Ask a method about every two maps."""
    pairs = itertools.combinations(method.maps, 2)
    return {(a, b): align(method.maps[a], method.maps[b], method=method) for a, b in pairs}


def join_jointly(method: Remembered, earlier: AlignmentGraph | None = None) -> tuple[Joined, AlignmentGraph]:
    """Join the maps by `rectmerge.align_many`."""
    asking, started = method.seconds, time.process_time()
    graph = align_many(method.maps, method=method, earlier=earlier)
    seconds = time.process_time() - started - (method.seconds - asking)
    asked = graph.pairs.asked
    joined = Joined(
        components=graph.components,
        pixels={name: placement.pixels for name, placement in graph.placements.items()},
        answers={pair: answer.alignment for pair, answer in asked.items() if answer.alignment is not None},
        bridges=graph.bridges,
        used=[pair for pair, answer in asked.items() if answer.status == "used"],
        seconds=seconds,
    )
    return joined, graph


def join_by_tree(answers: Mapping[Pair, Alignment]) -> Joined:
    """Join the maps by the accepted pairs, the most confident first, each that brings two components together."""
    members = {name: [name] for pair in answers for name in pair}
    pixels = {name: Similarity() for name in members}
    used = []
    for (a, b), answer in sorted(answers.items(), key=lambda item: (-item[1].confidence, item[0])):
        if answer.pixels is None or members[a] is members[b]:
            continue
        to_frame = pixels[a] @ answer.pixels @ pixels[b].inverse()
        for name in members[b]:
            pixels[name] = to_frame @ pixels[name]
        members[a].extend(members[b])
        members |= dict.fromkeys(members[b], members[a])
        used.append((a, b))
    components = {id(group): group for group in members.values() if len(group) > 1}
    joined = {name for group in components.values() for name in group}
    return Joined(
        components=list(components.values()),
        pixels={name: place for name, place in pixels.items() if name in joined},
        answers=answers,
        used=used,
    )


def make_lies(
    fleet_id: str, truth: Mapping[Pair, MapPair], answers: Mapping[Pair, Alignment]
) -> dict[Pair, Similarity]:
    """Choose a tenth of a fleet's pairs, and a wrong placement for each: the best wrong candidate of its answer.

    Where no candidate is wrong, a placement at random.
    """
    rng = np.random.default_rng(zlib.crc32(fleet_id.encode()))
    pairs = list(truth)
    chosen = rng.permutation(len(pairs))[: max(1, round(LIE_SHARE * len(pairs)))]
    lies = {}
    for pair in (pairs[index] for index in sorted(chosen)):
        wrong = (candidate.pixels for candidate in answers[pair].candidates if _is_off(candidate.pixels, truth[pair]))
        lies[pair] = next(wrong, None) or _at_random(truth[pair], rng)
    return lies


def _is_off(pixels: Similarity, pair: MapPair) -> bool:
    if pair.pixels is None:
        return True
    residual = (pair.residual_px or 0.0) / known_extent(pair.a)
    return grade(measure_errors(pixels, pair), residual) == "off"


def _at_random(pair: MapPair, rng: np.random.Generator) -> Similarity:
    turn = Similarity(pair.pixels.scale if pair.pixels else 1.0, float(rng.uniform(-math.pi, math.pi)))
    (height_a, width_a), (height_b, width_b) = pair.a.shape, pair.b.shape
    tx, ty = rng.uniform(*SHIFTS, 2) * [width_a, height_a] - turn.apply([width_b / 2, height_b / 2])
    return Similarity(turn.scale, turn.angle, float(tx), float(ty))


def _with_lie(answer: Alignment, lie: Similarity, a: OccupancyGrid, b: OccupancyGrid) -> Alignment:
    """Return an answer that is sure of a placement, and has its own candidates but the best behind it."""
    sure = {"plausibility": LIE_LOG_ODDS, "mirror_log_odds": -LIE_LOG_ODDS, "is_at_limit": 0.0, "slack_cells": 0.0}
    confidence = 1 / (1 + math.exp(-LIE_LOG_ODDS))
    candidate = Candidate.from_pixels(lie, a, b, confidence=confidence, evidence=sure)
    behind = [one for one in answer.candidates if one.pixels != lie]
    return dataclasses.replace(
        answer, verdict="accepted", confidence=confidence, reason="a lie", candidates=(candidate, *behind[1:])
    )


def method_of(name: str, maps: Mapping[str, OccupancyGrid]) -> Remembered:
    """Return a registered method that remembers its answers to some maps."""
    return Remembered(make_method(name), maps)
