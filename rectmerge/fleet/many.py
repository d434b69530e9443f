"""Alignment of any number of maps: likely partners are asked, all answers judged together, and every map placed."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge import methods
from rectmerge.aligning import Scale
from rectmerge.alignment import Alignment, Method
from rectmerge.derived import derived_kept
from rectmerge.errors import InputError
from rectmerge.fleet.asking import PairAsker, Progress, Questions
from rectmerge.fleet.assembling import assemble
from rectmerge.fleet.earlier import Earlier, describe_changes
from rectmerge.fleet.evidence import Evidence, Pair
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.fleet.joining import Joining
from rectmerge.fleet.journal import Journal
from rectmerge.fleet.map_sample import MapSample
from rectmerge.fleet.params import FleetParams
from rectmerge.fleet.signature import partners, signature, similarities
from rectmerge.fleet.wall_witness import WallWitness
from rectmerge.grid import OccupancyGrid, unusable
from rectmerge.methods import DEFAULT_METHOD

Maps = Mapping[str, OccupancyGrid] | Sequence[OccupancyGrid]


def align_many(
    maps: Maps,
    *,
    method: str | Method = DEFAULT_METHOD,
    scale: Scale = "auto",
    seed: int = 0,
    budget: int | None = None,
    earlier: AlignmentGraph | None = None,
    executor: Executor | None = None,
) -> AlignmentGraph:
    """Find which maps belong together and where each lies, or say of each that is left out why.

    Parameters
    ----------
    maps
        Two maps or more: names to maps, or a sequence, whose names are then "0", "1" and so on.
    method, scale, seed
        As for `rectmerge.align`, for every pair.
    budget
        Most pairs to ask; None for as many as the joins need, about five a map at most.
    earlier
        Graph of some of these maps. Its answers are taken over where the cells of both maps are the same, so that only
        pairs of new maps are asked. Its placements stay unless others are better by 3 nats; then `changes` says so.
    executor
        Asks pairs in parallel, such as a `concurrent.futures.ProcessPoolExecutor`; the answer is the same.

    Raises
    ------
    InputError
        If there are fewer than two maps, the budget is below 1, or the method or the scale cannot be used.

    Notes
    -----
    Each map's likely partners are asked, found by its rectangles (`rectmerge.fleet.signature`). Components are joined
    best first by the candidates of all asked pairs (`rectmerge.fleet.joining`), and placed by reweighted least squares
    (`rectmerge.fleet.placing`). Of two maps the answer is that of `rectmerge.align`.
    """
    chosen = methods.make_method(method) if isinstance(method, str) else method
    return build_graph(_named(maps), PairAsker(chosen, scale, seed), budget=budget, earlier=earlier, executor=executor)


def build_graph(
    named: Mapping[str, OccupancyGrid],
    ask: PairAsker,
    *,
    budget: int | None = None,
    earlier: AlignmentGraph | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    journal: Journal | None = None,
) -> AlignmentGraph:
    """Build the graph of some maps as `align_many` does; answers of the journal are taken over, new ones written."""
    started = time.perf_counter()
    if budget is not None and budget < 1:
        raise InputError(f"budget must be at least one pair, got {budget}")
    params = FleetParams()
    faults = {name: fault for name, grid in named.items() if (fault := unusable(grid))}
    order = {name: place for place, name in enumerate(named)}
    samples = {name: MapSample.from_grid(grid) for name, grid in named.items() if name not in faults}
    names = sorted(samples, key=lambda name: (samples[name].digest, order[name]))  # the same however they are given
    grids = [named[name] for name in names]
    evidence = Evidence([samples[name] for name in names], params.evidence, WallWitness(grids).log_odds)
    before = Earlier.of(earlier, names, samples)
    digests = [samples[name].digest for name in names]
    known = {**(journal.known(digests) if journal else {}), **before.answers}

    def keep(pair: Pair, answer: Alignment) -> None:
        if journal is not None:
            journal.add((digests[pair[0]], digests[pair[1]]), answer)

    questions = Questions(
        grids, names, [order[name] for name in names], evidence, ask,
        budget=budget, known=known, executor=executor, progress=progress, keep=keep,
    )  # fmt: skip
    with derived_kept():  # of each map, which is asked about many times
        joining, gain = _join(grids, evidence, questions, params, before)
    graph = assemble(named, names, faults, joining, questions, method=ask.method.name, started=started)
    return graph if earlier is None else replace(graph, changes=describe_changes(earlier, graph, named, gain))


def _named(maps: Maps) -> dict[str, OccupancyGrid]:
    named = dict(maps) if isinstance(maps, Mapping) else {str(index): grid for index, grid in enumerate(maps)}
    if len(named) < 2:
        raise InputError(f"align_many needs two maps or more, got {len(named)}")
    return named


def _join(
    grids: Sequence[OccupancyGrid], evidence: Evidence, questions: Questions, params: FleetParams, before: Earlier
) -> tuple[Joining, float]:
    """Join the maps; return the gain in nats over the earlier placements where others are taken, else 0."""
    questions.ask([(min(pair), max(pair)) for pair in before.answers])
    if len(grids) == 2:  # what the pair says is the answer
        joining = Joining(evidence, questions.ask, params)
        questions.ask([(0, 1)])
        if any(questions.answers.values()):
            joining.take((0, 1))
        return joining, 0.0
    if len(grids) < 2:
        return Joining(evidence, questions.ask, params), 0.0
    anew = _ask_and_join(grids, evidence, questions, params, before)
    if not before.components:
        return anew, 0.0
    kept = Joining(evidence, questions.ask, params, before.components)
    kept.run()
    gain = anew.total() - kept.total()
    return (anew, gain) if gain >= params.join.change_margin else (kept, 0.0)


def _ask_and_join(
    grids: Sequence[OccupancyGrid], evidence: Evidence, questions: Questions, params: FleetParams, before: Earlier
) -> Joining:
    """Ask the likely partners of each map, join, and ask more partners of the maps that are left alone."""
    cosine = similarities([signature(grid, params.partner) for grid in grids], params.partner)
    likely = sorted(partners(cosine, params.partner.partners), key=lambda pair: -cosine[pair])
    questions.ask([pair for pair in likely if not before.knows(pair)])
    while True:
        joining = Joining(evidence, questions.ask, params)
        joining.run()
        left = params.partner.pairs_per_map * len(grids) - len(questions.answers)
        pairs = [pair for pair in _of_alone(joining, cosine) if not before.knows(pair)]
        if left <= 0 or not questions.ask(pairs[:left]):
            return joining


def _of_alone(joining: Joining, cosine: NDArray[np.float64]) -> list[Pair]:
    """List the pairs of each map left alone with the most similar map of each component, the most similar first."""
    alone = [members[0] for members in joining.members.values() if len(members) == 1]
    pairs: dict[Pair, float] = {}
    for index in alone:
        for members in joining.members.values():
            rest = [
                other
                for other in members
                if other != index and not joining.evidence.is_asked((min(index, other), max(index, other)))
            ]
            if rest:
                best = max(rest, key=lambda other: cosine[index, other])
                pairs[min(index, best), max(index, best)] = -float(cosine[index, best])
    return sorted(pairs, key=lambda pair: (pairs[pair], pair))
