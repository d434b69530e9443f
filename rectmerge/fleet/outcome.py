"""Outcome of a merge of many maps: merged maps, pictures, and the summary for the terminal."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from rectmerge.composing.compose import CellsOf, Composition, Rule, compose
from rectmerge.drawing.many_maps import EDGE_LEGEND, Edge, draw_graph, draw_many
from rectmerge.drawing.maps import Picture, draw_conflict
from rectmerge.elastic.bend import Bend
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels

Answer = Literal["accepted", "rejected", "ambiguous"]
DRAWN = {"used": "used", "promoted": "promoted by others", "thrown out": "thrown out (dashed)"}


def answer_of(graph: AlignmentGraph) -> Answer:
    """Return the answer as a verdict: all in one, some left out, or nothing joined and something ambiguous."""
    if graph:
        return "accepted"
    is_open = any(answer.status == "undecided" for answer in graph.pairs.asked.values())
    return "ambiguous" if is_open and not graph.components else "rejected"


def merged_stems(graph: AlignmentGraph, reference: str) -> list[str]:
    """Return the stem of each component's merged map: "merged" is that of the reference's component alone."""
    numbers = itertools.count(2)
    return ["merged" if reference in names else f"merged_{next(numbers)}" for names in graph.components]


def compose_component(
    graph: AlignmentGraph, names: Sequence[str], maps: Mapping[str, OccupancyGrid], rule: Rule, cells: CellsOf | float
) -> Composition:
    """Compose the maps of a component in the frame of its reference, the first of the names."""
    placements = [graph.placements[name].to_reference for name in names[1:]]
    return compose([maps[name] for name in names], [None, *placements], rule=rule, resolution=cells)


def component_pictures(
    graph: AlignmentGraph, names: Sequence[str], maps: Mapping[str, OccupancyGrid], composition: Composition, stem: str
) -> dict[str, Picture]:
    """Draw a component: its maps on each other, and where they contradict each other."""
    number = stem.removeprefix("merged")
    least = min(graph.placements[name].confidence for name in names)
    title = f"{len(names)} maps on {names[0]}, confidence {floored(least)} or more"
    pixels = {
        name: map_frame_to_pixels(graph.placements[name].to_reference, maps[names[0]], maps[name]) for name in names
    }
    overlay = draw_many({name: maps[name] for name in names}, pixels, title=title)
    return {f"overlay{number}.png": overlay, f"conflict{number}.png": draw_conflict(composition)}


def floored(confidence: float) -> str:
    """Print a confidence in two digits, rounded down: 1.00 is none but certainty."""
    return f"{math.floor(100 * confidence) / 100:.2f}"


def graph_picture(graph: AlignmentGraph, maps: Mapping[str, OccupancyGrid]) -> Picture:
    """Draw the graph: the maps of a component side by side, its pairs, and those thrown out."""
    ordered = [name for names in graph.components for name in names] + list(graph.left_out)
    edges = []
    for (a, b), answer in graph.pairs.asked.items():
        if answer.status in DRAWN:
            is_bridge = (a, b) in graph.bridges
            color = EDGE_LEGEND["bridge, rests on one pair" if is_bridge else DRAWN[answer.status]]
            is_dashed = answer.status == "thrown out"
            edges.append(Edge(a=a, b=b, color=color, is_dashed=is_dashed, is_thick=is_bridge))
    edges.sort(key=lambda edge: not edge.is_dashed)
    return draw_graph({name: maps[name] for name in ordered}, edges, title=headline(graph))


def headline(graph: AlignmentGraph) -> str:
    """Return what became of the maps in a line."""
    count = len(graph.names)
    if graph:
        return f"all {count} maps are in one"
    if not graph.components:
        return f"none of {count} maps is sure to belong to another"
    parts = f"{len(graph.components)} components of {' and '.join(str(len(names)) for names in graph.components)} maps"
    if len(graph.components) == 1:
        parts = f"{len(graph.components[0])} of {count} maps are in one"
    return parts + (f", {len(graph.left_out)} left out" if graph.left_out else "")


def describe(
    graph: AlignmentGraph,
    files: Sequence[Path] = (),
    *,
    merged: Sequence[str | None],
    bends: Mapping[str, Bend] = MappingProxyType({}),
) -> str:
    """Describe a graph: its components with the place of each map, what is left out and why, and the files."""
    lines = [headline(graph), f"  method      {graph.method}, {graph.seconds:.2f} s"]
    counts = Counter(answer.status for answer in graph.pairs.asked.values())
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    lines.append(f"  pairs       {graph.asked} of {len(graph.pairs)} asked: {told}")
    for names, file in zip(graph.components, merged, strict=True):
        lines.append(f"  component   {len(names)} maps in the frame of {names[0]}{f': {file}' if file else ''}")
        width = max(map(len, names))
        lines += [f"    {_describe_placement(graph, name, width)}" for name in names[1:]]
    lines += [f"  unbent      {name}: {'' if bend else 'no: '}{bend.reason}" for name, bend in bends.items()]
    lines += [f"  left out    {name}: {reason}" for name, reason in graph.left_out.items()]
    lines += [f"  changed     {name}: {reason}" for name, reason in graph.changes.items()]
    larger = {name for names in graph.components if len(names) > 2 for name in names}
    lines += [
        f"  bridge      {a} and {b}: only this pair joins the maps on its two sides; look at the overlay"
        for a, b in graph.bridges
        if a in larger
    ]
    if files:
        lines.append(f"  written     {files[0].parent}: {', '.join(file.name for file in files)}")
    return "\n".join(lines)


def _describe_placement(graph: AlignmentGraph, name: str, width: int) -> str:
    placement = graph.placements[name]
    place = placement.to_reference
    turn = math.degrees(math.remainder(place.angle, math.tau))
    return (
        f"{name:<{width}}  {turn:+.2f} deg, scale {placement.pixels.scale:.4f}, shift {place.tx:+.2f}, {place.ty:+.2f} "
        f"{placement.unit}; confidence {floored(placement.confidence)}, by {len(placement.rests_on)} of the pairs"
    )
