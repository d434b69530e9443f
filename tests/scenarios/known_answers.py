"""Small pairs, sources and methods with known answers, for the tests of the benchmark."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass, fields

import cv2
import numpy as np

from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.bench.contenders import Contender
from scenarios.bench.plan import RunPlan
from scenarios.bench.run import Execution, RunCallbacks, run
from scenarios.pairs.map_view import PlacedMap
from scenarios.pairs.pair import MapPair, MissionPairs

TRUTH = Similarity(1.0, 0.0, 4.0, 2.0)


def grid(height: int = 40, width: int = 60) -> OccupancyGrid:
    """A walled room that fills its map."""
    cells = np.full((height, width), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    return OccupancyGrid(cells)


def pair(pair_id: str = "p0", *, related: bool = True, truth: Similarity = TRUTH, **changes: object) -> MapPair:
    """Two rooms, the second shifted, with exact control points."""
    points_b = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0], [12.0, 7.0]])
    content = {
        "pair_id": pair_id,
        "a": grid(),
        "b": grid(),
        "related": related,
        "pixels": truth if related else None,
        "control_points": np.hstack([truth.apply(points_b), points_b]) if related else None,
        "residual_px": 0.0 if related else None,
        "suite": "made",
        "place": pair_id,
        "overlap": 0.8 if related else 0.0,
        **changes,
    }
    return MapPair(**content)


def run_pairs(sources, contenders, out, *, suite="made", seed=0, about=None, card=None, **options):
    """Run contenders on pairs; options are those of `run`, and the fields of `Execution` and `RunCallbacks`."""
    plan = RunPlan(suite=suite, sources=sources, contenders=contenders, seed=seed, about=about or {}, card=card)
    execution, callbacks = (
        kind(**{field.name: options.pop(field.name) for field in fields(kind) if field.name in options})
        for kind in (Execution, RunCallbacks)
    )
    return run(plan, out, execution=execution, callbacks=callbacks, **options)


def pixel_to_world(placed: PlacedMap, pixels: np.ndarray) -> np.ndarray:
    """Invert `world_to_pixel`, which is affine, from three points."""
    base = placed.world_to_pixel([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    forward = np.stack([base[1] - base[0], base[2] - base[0]], axis=1)
    return np.linalg.solve(forward, (pixels - base[0]).T).T


@dataclass(frozen=True, kw_only=True)
class Source:
    """One related pair and one unrelated pair; can fail before the second."""

    source_id: str = "m0"
    fails: bool = False

    @property
    def pair_ids(self) -> tuple[str, ...]:
        return (f"{self.source_id}-related", f"{self.source_id}-unrelated")

    def is_related(self, pair_id: str) -> bool:
        return pair_id == self.pair_ids[0]

    def pairs(self) -> Iterator[MapPair]:
        yield pair(self.pair_ids[0])
        if self.fails:
            raise RuntimeError("the robot fell over")
        yield pair(self.pair_ids[1], related=False)


@dataclass(frozen=True, kw_only=True)
class Lost(Source):
    """A mission that hangs, or takes its process along."""

    how: str = "hang"

    def mission_pairs(self) -> MissionPairs:
        if self.how == "hang":
            time.sleep(30)
        os._exit(7)


@dataclass(frozen=True, kw_only=True)
class Fixed:
    """Answers what it is told to."""

    name: str = "fixed"
    verdict: str = "accepted"
    tx: float = TRUTH.tx
    confidence: float = 0.75

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        wrong = Candidate.from_pixels(Similarity(1.0, 0.0, -20.0, 2.0), a, b, confidence=0.1)
        best = Candidate.from_pixels(Similarity(1.0, 0.0, self.tx, TRUTH.ty), a, b, confidence=self.confidence)
        return Alignment(
            verdict=self.verdict,
            reason="as told",
            method=self.name,
            candidates=(wrong, best) if self.verdict == "ambiguous" else (best,),
            confidence=self.confidence,
            trace={"draw": rng.integers(0, 1000), "ratio": float("inf")},
        )


@dataclass(frozen=True, kw_only=True)
class Failing:
    """Fails as it is told to."""

    name: str = "failing"
    how: str = "raise"

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        if self.how == "memory":
            raise MemoryError
        if self.how == "opencv memory":
            cv2.resize(np.zeros((2, 2), np.uint8), (2_000_000_000, 1_000_000))
        if self.how == "hang":
            time.sleep(30)
        if self.how == "greedy":
            taken = [np.ones(2**20) for _ in range(1000)]
            time.sleep(30 + len(taken))
        if self.how == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.how == "exit":
            os._exit(7)
        raise ZeroDivisionError("no rectangles\nat all")


def contender(method: object = None, label: str = "one") -> Contender:
    """Enter a method, `Fixed` unless given."""
    return Contender(label=label, method=method or Fixed())


def outcomes(rows) -> list[tuple[str, str, str]]:
    """List pair, method and outcome of rows of results."""
    return [(row["pair_id"], row["method"], row["outcome"]) for row in rows]
