"""Earlier graph of some of the maps: answers that still hold, and placements that stay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rectmerge.alignment import Alignment
from rectmerge.analysis.displacement import displacement_cells
from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.evidence import Pair
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.fleet.map_sample import MapSample
from rectmerge.grid import OccupancyGrid

MOVED_CELLS = 0.5  # of the reference: a smaller change is none


@dataclass(frozen=True, slots=True)
class Earlier:
    """Parts of an earlier graph that are about unchanged maps, by the indices of the maps.

    Parameters
    ----------
    maps
        The unchanged maps.
    answers
        Answers by (A, B).
    components
        Poses of the maps of each component of two or more.
    """

    maps: frozenset[int]
    answers: Mapping[tuple[int, int], Alignment]
    components: Sequence[Mapping[int, ComplexSimilarity]]

    @classmethod
    def of(cls, graph: AlignmentGraph | None, names: Sequence[str], samples: Mapping[str, MapSample]) -> Earlier:
        """Take what holds of a graph for maps of these names; nothing of None."""
        if graph is None:
            return cls(frozenset(), {}, ())
        at = {name: index for index, name in enumerate(names) if graph.digests.get(name) == samples[name].digest}
        answers = {
            (at[a], at[b]): answer.alignment
            for (a, b), answer in graph.pairs.asked.items()
            if a in at and b in at and answer.alignment is not None
        }
        poses = (
            {at[name]: ComplexSimilarity.from_similarity(graph.placements[name].pixels) for name in group if name in at}
            for group in graph.components
        )
        return cls(frozenset(at.values()), answers, [group for group in poses if len(group) > 1])

    def knows(self, pair: Pair) -> bool:
        """Return whether the earlier graph had both maps of a pair."""
        return self.maps.issuperset(pair)


def describe_changes(
    earlier: AlignmentGraph, graph: AlignmentGraph, maps: Mapping[str, OccupancyGrid], gain: float
) -> dict[str, str]:
    """Return, for each map whose earlier placement has changed, its new one in a line.

    Parameters
    ----------
    earlier, graph
        The graphs.
    maps
        The maps of the second graph by name.
    gain
        Nats by which its placements are better.
    """
    changes = {}
    for name, before in earlier.placements.items():
        if name not in maps or earlier.digests.get(name) != graph.digests.get(name):
            continue
        now, reference = graph.placements.get(name), graph.placements.get(before.reference)
        if now is None:
            changes[name] = f"left out now: {graph.left_out[name]}"
        elif reference is None or reference.reference != now.reference:
            if before.reference in maps and name != before.reference:
                changes[name] = f"no longer together with {before.reference}"
        else:
            relative = reference.pixels.inverse() @ now.pixels
            moved = displacement_cells(maps[name], before.pixels, relative)
            if moved > MOVED_CELLS and earlier.digests[before.reference] == graph.digests[before.reference]:
                better = f"the new placements are better by {gain:.1f} nats"
                changes[name] = f"moved by {moved:.1f} cells of {before.reference}: {better}"
    return changes
