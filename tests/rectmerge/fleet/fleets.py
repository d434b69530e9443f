"""Fleets of drawn maps with known truth, and a method whose answers about them are made, right or wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rectmerge.alignment import Alignment, Candidate
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.fleet.map_sample import digest
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

SIDE = 240


@dataclass
class Fleet:
    """Maps by name, the building of each, and the placement of each in its building's pixels."""

    maps: dict[str, OccupancyGrid] = field(default_factory=dict)
    place: dict[str, str] = field(default_factory=dict)
    poses: dict[str, Similarity] = field(default_factory=dict)

    def add(self, name: str, place: str, grid: OccupancyGrid, pose: Similarity) -> None:
        self.maps[name], self.place[name], self.poses[name] = grid, place, pose

    def b_to_a(self, a: str, b: str) -> Similarity:
        """The true placement of B's pixels on A's."""
        return self.poses[a].inverse() @ self.poses[b]

    def error(self, found: Similarity, a: str, b: str) -> float:
        """Greatest error of a placement at the corners of B, as a share of A's diagonal."""
        height, width = self.maps[b].shape
        corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], np.float64)
        apart = found.apply(corners) - self.b_to_a(a, b).apply(corners)
        return float(np.hypot(*apart.T).max() / np.hypot(*self.maps[a].shape))


def plan(seed: int, side: int = SIDE) -> OccupancyGrid:
    """Draw a building of rooms of random sizes with doors between them, in cells."""
    rng = np.random.default_rng(seed)
    free = np.ones((side - 8, side - 8), np.bool_)

    def split(top: int, left: int, height: int, width: int) -> None:
        if max(height, width) < 40 or (max(height, width) < 90 and rng.random() < 0.25):
            return
        if height > width:
            at = top + int(height * rng.uniform(0.3, 0.7))
            free[at : at + 2, left : left + width] = False
            door = left + int(rng.integers(0, max(1, width - 8)))
            split(top, left, at - top, width)
            split(at + 2, left, top + height - at - 2, width)
            free[at : at + 2, door : door + 8] = True
        else:
            at = left + int(width * rng.uniform(0.3, 0.7))
            free[top : top + height, at : at + 2] = False
            door = top + int(rng.integers(0, max(1, height - 8)))
            split(top, left, height, at - left)
            split(top, at + 2, height, left + width - at - 2)
            free[door : door + 8, at : at + 2] = True

    split(0, 0, *free.shape)
    return drawing.grid_of(np.pad(free, 4))


def window(
    building: OccupancyGrid, rng: np.random.Generator, middle: tuple[float, float], side: int
) -> tuple[OccupancyGrid, Similarity]:
    """Map a square part of a building about its `middle` (u, v), turned and rescaled, with 1 % of salt."""
    turn = Similarity(float(rng.uniform(0.8, 1.25)), float(rng.uniform(-math.pi, math.pi)))
    cells = int(side / turn.scale)
    tx, ty = np.array(middle) - turn.apply([cells / 2, cells / 2])
    pose = Similarity(turn.scale, turn.angle, float(tx), float(ty))
    grid = drawing.view(building, pose, (cells, cells))
    occupancy = grid.occupancy.copy()
    salt = (rng.random(occupancy.shape) < 0.01) & (occupancy >= 0)
    occupancy[salt] = rng.choice(np.array([FREE, OCCUPIED], np.int8), int(salt.sum()))
    return OccupancyGrid(occupancy), pose


def fleet(seed: int, home: int = 5, other: int = 2, side: int = 130) -> Fleet:
    """Draw maps of parts of one building, along its diagonal, and of another."""
    rng = np.random.default_rng(seed)
    made = Fleet()
    for place, count, number in (("home", home, 2 * seed), ("other", other, 2 * seed + 1)):
        building = plan(number)
        for index, share in enumerate(np.linspace(0.0, 1.0, count)):
            middle = side / 2 + share * (SIDE - side) * np.array([1.0, 1.0]) + rng.uniform(-12, 12, 2) * [1, -1]
            made.add(f"{place}{index}", place, *window(building, rng, (float(middle[0]), float(middle[1])), side))
    return made


@dataclass(frozen=True)
class Oracle:
    """Method that knows a fleet's truth: an answer with some noise where maps overlap, and none where they do not.

    `lies` are accepted placements of B on A that it gives instead, `doubts` pairs for which it offers the truth and a
    placement beside it as equally good, and `blind` pairs of which it says nothing.
    """

    fleet: Fleet
    noise: float = 0.002
    log_odds: float = 6.0
    lies: dict[tuple[str, str], Similarity] = field(default_factory=dict)
    lie_log_odds: float = 6.0
    doubts: frozenset[tuple[str, str]] = frozenset()
    blind: frozenset[tuple[str, str]] = frozenset()
    name: str = "oracle"
    asked: list[tuple[str, str]] = field(default_factory=list)

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        names = {digest(grid): name for name, grid in self.fleet.maps.items()}
        pair = names[digest(a)], names[digest(b)]
        self.asked.append(pair)
        if pair in self.lies or pair[::-1] in self.lies:
            lie = self.lies[pair] if pair in self.lies else self.lies[pair[::-1]].inverse()
            return self._answer(a, b, [(lie, self.lie_log_odds)])
        truth = self.fleet.b_to_a(*pair)
        is_blind = pair in self.blind or pair[::-1] in self.blind
        if self.fleet.place[pair[0]] != self.fleet.place[pair[1]] or is_blind or not self._overlaps(a, b, truth):
            return self._answer(a, b, [(self._near(truth, b, rng, 0.5), -4.0)])
        told = self._near(truth, b, rng, self.noise)
        if pair in self.doubts or pair[::-1] in self.doubts:
            return self._answer(a, b, [(self._near(truth, b, rng, 0.4), 3.0), (told, 2.9)])
        return self._answer(a, b, [(told, self.log_odds)])

    def _overlaps(self, a: OccupancyGrid, b: OccupancyGrid, truth: Similarity) -> bool:
        return Candidate.from_pixels(truth, a, b, confidence=1.0).overlap > 0.2

    def _near(self, truth: Similarity, b: OccupancyGrid, rng: np.random.Generator, share: float) -> Similarity:
        """Return a placement whose corners are off by about a share of the diagonal."""
        diagonal = math.hypot(*b.shape) * truth.scale
        u, v = b.shape[1] / 2, b.shape[0] / 2
        turn = Similarity(math.exp(rng.normal(0, share)), float(rng.normal(0, share)))
        shift = truth.apply([u, v]) + rng.normal(0, share * diagonal, 2) - turn.apply(truth.apply([u, v]))
        return Similarity(turn.scale, turn.angle, float(shift[0]), float(shift[1])) @ truth

    def _answer(self, a: OccupancyGrid, b: OccupancyGrid, told: list[tuple[Similarity, float]]) -> Alignment:
        odds = [nats for _, nats in told]
        against = np.logaddexp.reduce([0.0, *odds[1:]])
        best = 1 / (1 + math.exp(against - odds[0]))
        candidates = tuple(
            Candidate.from_pixels(
                place, a, b, confidence=best, evidence={"plausibility": nats, "clutter": 40.0, "clutter_matched": 1.0}
            )
            for place, nats in told
        )
        verdict = "accepted" if best >= 0.85 else "ambiguous" if odds[0] > 2 else "rejected"
        return Alignment(verdict=verdict, reason="as told", method=self.name, candidates=candidates, confidence=best)


def members(graph: AlignmentGraph) -> set[frozenset[str]]:
    """The names of the maps of each component."""
    return {frozenset(names) for names in graph.components}


def worst_error(made: Fleet, graph: AlignmentGraph) -> float:
    """Greatest error of the placements of two maps of one component, one on the other."""
    return max(
        made.error(graph.placements[a].pixels.inverse() @ graph.placements[b].pixels, a, b)
        for names in graph.components
        for a in names
        for b in names
        if a != b
    )
