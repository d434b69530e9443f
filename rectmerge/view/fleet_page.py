"""Page of many maps: each component with its maps to fade, the graph of their pairs, and the reasons."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from string import Template

import numpy as np
from numpy.typing import NDArray

from rectmerge.drawing.many_maps import EDGE_LEGEND, WALLS
from rectmerge.drawing.maps import Color
from rectmerge.fleet.graph import AlignmentGraph, PairAnswer
from rectmerge.fleet.outcome import DRAWN, floored, headline
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from rectmerge.view.embedding import package_text
from rectmerge.view.pictures import draw_one

MAX_SIDE_PIXELS = 700  # of a map
THUMBNAIL_PIXELS = 90
GREY_MAP = ("#F2F2F2", "#404040")
TINT = 0.12  # share of a map's colour in its free space


def html(graph: AlignmentGraph, maps: Mapping[str, OccupancyGrid]) -> str:
    """Return the page of a graph with the maps that were read for it, by name."""
    left_out = "".join(f"<li><b>{escape(name)}</b>: {escape(reason)}</li>" for name, reason in graph.left_out.items())
    return Template(package_text("fleet.html")).substitute(
        style=package_text("page.css"),
        headline=escape(headline(graph)),
        pairs=f"{graph.asked} of {len(graph.pairs)} pairs asked",
        method=escape(graph.method),
        components="\n".join(
            _component(graph, names, maps, number) for number, names in enumerate(graph.components, start=1)
        ),
        graph=_graph(graph, maps),
        left_out=f"<section><h2>Left out</h2><ul>{left_out}</ul></section>" if left_out else "",
        rows="\n".join(_rows(graph)),
    )


def _component(graph: AlignmentGraph, names: Sequence[str], maps: Mapping[str, OccupancyGrid], number: int) -> str:
    """Draw the maps of a component on each other, each with a slider."""
    layers, items, corners = [], [], []
    for index, name in enumerate(names):
        key, color, place = f"map-{number}-{index}", WALLS[index % len(WALLS)], graph.placements[name]
        layer, ends = _layer(key, name, maps[name], place.pixels, color)
        layers.append(layer)
        corners.append(ends)
        items.append(
            f'<li><label><span class="swatch" style="background:{_hex(color)}"></span>{escape(name)} '
            f'<span class="faint">confidence {floored(place.confidence)}</span><br>'
            f'<input type="range" min="0" max="1" step="0.05" value="0.8" data-layer="{key}"></label></li>'
        )
    left, top = np.min(np.concatenate(corners), axis=0)
    wide, high = np.ptp(np.concatenate(corners), axis=0)
    title = f"{len(names)} maps in the frame of {escape(names[0])}"
    return (
        f'<section><h2>{title}</h2><svg viewBox="{left:.2f} {top:.2f} {wide:.2f} {high:.2f}" role="img" '
        f'aria-label="{title}">{"".join(reversed(layers))}</svg><ul class="maps">{"".join(items)}</ul></section>'
    )


def _layer(
    key: str, name: str, grid: OccupancyGrid, pixels: Similarity, color: Color
) -> tuple[str, NDArray[np.float64]]:
    """Return a map as an image in the reference's pixels, and its corners there, shape (4, 2)."""
    address, (width, height), to_map = draw_one(grid, MAX_SIDE_PIXELS, (_hex(color, TINT), _hex(color)))
    on_page = pixels @ to_map @ Similarity(tx=-0.5, ty=-0.5)  # an image begins at its first pixel's corner
    (a, b, tx), (c, d, ty) = on_page.matrix.tolist()
    matrix = f"matrix({a:.9g} {c:.9g} {b:.9g} {d:.9g} {tx:.9g} {ty:.9g})"
    image = f'<image id="{key}" width="{width}" height="{height}" href="{address}" transform="{matrix}">'
    corners = on_page.apply([[0, 0], [width, 0], [0, height], [width, height]])
    return f"{image}<title>{escape(name)}</title></image>", corners


def _graph(graph: AlignmentGraph, maps: Mapping[str, OccupancyGrid]) -> str:
    """Draw the maps around a circle, those of a component side by side, and the pairs between them."""
    names = [name for group in graph.components for name in group] + list(graph.left_out)
    radius = max(1.6 * THUMBNAIL_PIXELS, (THUMBNAIL_PIXELS + 30) * len(names) / math.tau)
    turns = (math.tau * index / len(names) - math.pi / 2 for index in range(len(names)))
    at = {name: (radius * math.cos(turn), radius * math.sin(turn)) for name, turn in zip(names, turns, strict=True)}
    lines = [
        _line(a, b, answer, (*at[a], *at[b]), is_bridge=(a, b) in graph.bridges)
        for (a, b), answer in graph.pairs.asked.items()
        if answer.status in DRAWN
    ]
    nodes = [_node(name, maps[name], at[name], graph.left_out.get(name, "")) for name in names]
    side = radius + THUMBNAIL_PIXELS
    box = f"{-side:.0f} {-side:.0f} {2 * side:.0f} {2 * side:.0f}"
    return f'<svg viewBox="{box}" role="img" aria-labelledby="graph-title">{"".join(lines + nodes)}</svg>'


def _line(a: str, b: str, answer: PairAnswer, ends: tuple[float, ...], *, is_bridge: bool) -> str:
    place = " ".join(f'{key}="{value:.1f}"' for key, value in zip(("x1", "y1", "x2", "y2"), ends, strict=True))
    color = EDGE_LEGEND["bridge, rests on one pair" if is_bridge else DRAWN[answer.status]]
    told = escape(f"{a} and {b}: {'bridge, ' if is_bridge else ''}{_told(answer)}")
    kind = answer.status.replace(" ", "-")
    return f'<line class="{kind}" {place} stroke="{_hex(color)}"><title>{told}</title></line>'


def _node(name: str, grid: OccupancyGrid, at: tuple[float, float], reason: str) -> str:
    address, (width, height), _ = draw_one(grid, THUMBNAIL_PIXELS, GREY_MAP)
    x, y = at
    box = f'x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width}" height="{height}"'
    return (
        f"<g><title>{escape(f'{name}: {reason}' if reason else name)}</title>"
        f'<rect {box} fill="#fff" stroke="#888"/><image {box} href="{address}"/>'
        f'<text x="{x:.1f}" y="{y + height / 2 + 14:.1f}" text-anchor="middle">{escape(name)}</text></g>'
    )


def _rows(graph: AlignmentGraph) -> Iterator[str]:
    for (a, b), answer in sorted(graph.pairs.asked.items()):
        cells = (f"{a} and {b}", answer.status, answer.reason)
        yield "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _told(answer: PairAnswer) -> str:
    confidence = "" if answer.alignment is None else f" (confidence {answer.alignment.confidence:.2f})"
    return f"{answer.status}{confidence}: {answer.reason}"


def _hex(color: Color, share: float = 1.0) -> str:
    """Write a colour, or a share of it in white, as "#RRGGBB"."""
    return "#" + "".join(f"{round(255 + share * (level - 255)):02X}" for level in color)
