"""Graph assembled from joined components: placements relative to each reference, the part of each pair, reasons."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np

from rectmerge.fleet import reasons
from rectmerge.fleet.asking import Questions
from rectmerge.fleet.bridges import find_bridges
from rectmerge.fleet.complex_similarity import ComplexSimilarity, rms, to_complex
from rectmerge.fleet.confidence import confidences
from rectmerge.fleet.evidence import Pair, PairCandidate, relative
from rectmerge.fleet.graph import AlignmentGraph, PairAnswer, Pairs, Placement
from rectmerge.fleet.joining import Joining
from rectmerge.fleet.uncertainty import Measurement, covariances, unsure
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity


def assemble(
    named: Mapping[str, OccupancyGrid],
    names: Sequence[str],
    faults: Mapping[str, str],
    joining: Joining,
    questions: Questions,
    *,
    method: str,
    started: float,
) -> AlignmentGraph:
    """Assemble the graph of some maps.

    Parameters
    ----------
    named
        All maps by name, in the order given.
    names
        Names of the maps that were joined, by their indices.
    faults
        Reason for each map that could not be joined.
    joining, questions
        Components, and all answers.
    method
        Name of the method.
    started
        Start of the wall time.
    """
    order = {name: place for place, name in enumerate(named)}
    groups = [sorted(members, key=lambda index: order[names[index]]) for members in joining.members.values()]
    groups.sort(key=lambda members: (-len(members), order[names[members[0]]]))
    joined = [members for members in groups if len(members) > 1]
    agreeing = [edge for members in joined for edge in joining.evidence.agreeing(members, joining.poses)]
    if len(names) == 2:  # what their pair accepts counts, whatever it claims
        agreeing = [edge for join in joining.joins for edge in join.agreeing]
    asked = _answers(names, joining, questions, agreeing)
    placements: dict[str, Placement] = {}
    for members in joined:
        placements |= _placements(members, names, named, joining, questions, agreeing)
    left_out = dict(faults)
    for members in groups[len(joined) :]:
        name = names[members[0]]
        own = {pair: answer for pair, answer in asked.items() if name in pair}
        left_out[name] = reasons.of_left_out(name, own, len(named) - 1, is_spent=questions.is_spent)
    return AlignmentGraph(
        names=tuple(named),
        components=tuple(tuple(names[index] for index in members) for members in joined),
        placements=placements,
        pairs=Pairs(tuple(named), asked),
        left_out={name: left_out[name] for name in named if name in left_out},
        bridges=tuple(sorted(find_bridges(_named_pair(edge.pair, names, order) for edge in agreeing))),
        method=method,
        digests={name: sample.digest for name, sample in zip(names, joining.evidence.maps, strict=True)},
        seconds=time.perf_counter() - started,
    )


def _named_pair(pair: Pair, names: Sequence[str], order: Mapping[str, int]) -> tuple[str, str]:
    a, b = sorted((names[index] for index in pair), key=order.__getitem__)
    return a, b


def _answers(
    names: Sequence[str], joining: Joining, questions: Questions, agreeing: Sequence[PairCandidate]
) -> dict[tuple[str, str], PairAnswer]:
    """Return the answer and the status of each asked pair."""
    component = {index: root for root, members in joining.members.items() for index in members}
    agrees = {edge.pair: edge for edge in agreeing}
    answers = {}
    for (a, b), alignment in questions.answers.items():
        pair = (min(a, b), max(a, b))
        if pair in agrees:
            answer = reasons.of_agreeing(alignment, agrees[pair].rank + 1)
        elif component[a] == component[b]:
            overlap = joining.evidence.overlap(pair, relative(joining.poses, pair))
            answer = reasons.of_disagreeing(alignment, overlap, is_joined=True)
        else:
            is_joined = any(len(joining.members[component[index]]) > 1 for index in pair)
            answer = reasons.of_disagreeing(alignment, None, is_joined=is_joined)
        answers[names[a], names[b]] = answer
    return answers


def _placements(
    members: Sequence[int],
    names: Sequence[str],
    named: Mapping[str, OccupancyGrid],
    joining: Joining,
    questions: Questions,
    agreeing: Sequence[PairCandidate],
) -> dict[str, Placement]:
    """Return the placements of a component's maps relative to the first of them."""
    reference = members[0]
    grids = {index: named[names[index]] for index in members}
    edges = [edge for edge in agreeing if edge.pair[0] in grids]
    to_reference = joining.poses[reference].inverse()
    pixels = {index: (to_reference @ joining.poses[index]).to_similarity() for index in members}
    pixels[reference] = Similarity()
    if len(members) == 2:  # what the pair says, to the last bit
        pixels[members[1]] = _pixels(edges[0], reference, questions)
    in_map_frame = {index: pixels_to_map_frame(pixels[index], grids[reference], grids[index]) for index in members}
    in_map_frame[reference] = Similarity()  # exactly
    order = {name: place for place, name in enumerate(named)}
    certain = confidences(members, reference, [edge.pair for edge in edges], joining)
    if len(named) == 2:
        certain[members[1]] = next(iter(questions.answers.values())).confidence
    unsureness = covariances(
        {names[index]: ComplexSimilarity.from_similarity(in_map_frame[index]) for index in members},
        {names[index]: _map_point(grids[index], joining.evidence.maps[index].centre) for index in members},
        [_measurement(edge, names, grids, questions) for edge in edges],
        names[reference],
    )
    return {
        names[index]: Placement(
            reference=names[reference],
            to_reference=in_map_frame[index],
            pixels=pixels[index],
            confidence=certain[index],
            covariance=unsureness.get(names[index]),
            unit=grids[reference].unit,
            rests_on=tuple(_named_pair(edge.pair, names, order) for edge in edges if index in edge.pair),
        )
        for index in members
    }


def _pixels(edge: PairCandidate, reference: int, questions: Questions) -> Similarity:
    """Return the placement of a pair's other map on the reference."""
    a, b = edge.pair if edge.pair in questions.answers else edge.pair[::-1]
    pixels = questions.answers[a, b].candidates[edge.rank].pixels
    return pixels if a == reference else pixels.inverse()


def _measurement(
    edge: PairCandidate, names: Sequence[str], grids: Mapping[int, OccupancyGrid], questions: Questions
) -> Measurement:
    """Return the placement of B on A of a pair with its covariance about the middle of the shared area."""
    a, b = edge.pair if edge.pair in questions.answers else edge.pair[::-1]
    candidate = questions.answers[a, b].candidates[edge.rank]
    middle = complex((edge.images if a < b else edge.points).mean())
    covariance = candidate.covariance
    if covariance is None:
        own = edge.images if a < b else edge.points
        cells = edge.span if a < b else edge.span / edge.placement.scale
        covariance = unsure(cells * grids[a].cell_size, rms(own - own.mean()) * grids[a].cell_size)
    return Measurement(names[a], names[b], _map_point(grids[a], middle), np.asarray(covariance))


def _map_point(grid: OccupancyGrid, pixel: complex) -> complex:
    return complex(to_complex(grid.pixel_to_map([pixel.real, pixel.imag])))
