"""Bridges of a graph: edges without which it falls apart (R. E. Tarjan, 1974, DOI 10.1016/0020-0190(74)90003-9)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from typing import TypeVar

Node = TypeVar("Node", bound=Hashable)


def find_bridges(edges: Iterable[tuple[Node, Node]]) -> set[tuple[Node, Node]]:
    """Return the bridges among the edges of a graph without double edges.

    Examples
    --------
    >>> sorted(find_bridges([(0, 1), (1, 2), (0, 2), (2, 3)]))
    [(2, 3)]
    """
    edges = list(edges)
    beside: dict[Node, list[tuple[Node, tuple[Node, Node]]]] = {}
    for a, b in edges:
        beside.setdefault(a, []).append((b, (a, b)))
        beside.setdefault(b, []).append((a, (a, b)))
    entered: dict[Node, int] = {}
    lowest: dict[Node, int] = {}
    bridges: set[tuple[Node, Node]] = set()
    for root in beside:
        if root in entered:
            continue
        entered[root] = lowest[root] = len(entered)
        path: list[tuple[Node, tuple[Node, Node] | None, Iterator[tuple[Node, tuple[Node, Node]]]]]
        path = [(root, None, iter(beside[root]))]
        while path:
            node, came_by, rest = path[-1]
            for other, edge in rest:
                if edge == came_by:
                    continue
                if other in entered:
                    lowest[node] = min(lowest[node], entered[other])
                    continue
                entered[other] = lowest[other] = len(entered)
                path.append((other, edge, iter(beside[other])))
                break
            else:
                path.pop()
                if path:
                    parent = path[-1][0]
                    lowest[parent] = min(lowest[parent], lowest[node])
                    if came_by is not None and lowest[node] > entered[parent]:
                        bridges.add(came_by)
    return bridges
