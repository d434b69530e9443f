"""A suite of drawn rooms without a simulator, and a process that makes a data set of it, to be killed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.dataset.generate import generate
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse
from scenarios.suites.spec import Seeds

SHIFT = (7, 4)  # of map B's window in the building


def building(seed: int) -> np.ndarray:
    """Rooms behind walls, with unknown cells around."""
    rng = np.random.default_rng(seed)
    cells = np.full((60, 80), UNKNOWN, np.int8)
    cv2.rectangle(cells, (4, 4), (75, 55), OCCUPIED, 1)
    cells[5:55, 5:75] = FREE
    cells[5:55, rng.integers(20, 60)] = OCCUPIED
    cells[rng.integers(15, 45), 5:75] = OCCUPIED
    return cells


@dataclass(frozen=True, kw_only=True)
class Rooms:
    """One related pair, one unrelated pair, by the seed; B's resolution may be known."""

    seed: int
    entropy: int | None = None  # where the cells are drawn from; the seed unless given
    fails: bool = False

    @property
    def source_id(self) -> str:
        return f"rooms-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        return (f"{self.source_id}-same", f"{self.source_id}-other")

    def is_related(self, pair_id: str) -> bool:
        return pair_id == self.pair_ids[0]

    def pairs(self) -> Iterator[MapPair]:
        drawn_from = self.seed if self.entropy is None else self.entropy
        cells, rng = building(drawn_from), np.random.default_rng(drawn_from)
        a, b = OccupancyGrid(cells), OccupancyGrid(cells[SHIFT[1] :, SHIFT[0] :], 0.05, (1.5, -2.0, 0.0))
        at_b = rng.uniform(0, 50, (30, 2))
        points = np.hstack([at_b + SHIFT + rng.normal(0, 0.3, (30, 2)), at_b])
        pixels = Similarity.fit(points[:, 2:], points[:, :2])
        split = "train" if self.seed % 3 == 0 else "test"
        info = {
            "split": split,
            "family": "rooms",
            "noise": 0,
            "resolution_a": 0.04,
            "resolution_b": 0.05,
            "ratio": 1.25,
        }
        yield MapPair(
            pair_id=self.pair_ids[0],
            a=a,
            b=b,
            related=True,
            pixels=pixels,
            control_points=points,
            residual_px=control_point_rmse(pixels.matrix, points),
            suite="tiny",
            place=f"tiny/{self.source_id}",
            overlap=measure_agreement(a, b, pixels).overlap,
            info=info,
        )
        if self.fails:
            raise RuntimeError("the robot fell over")
        other = OccupancyGrid(building(drawn_from + 10_000))
        yield MapPair(
            pair_id=self.pair_ids[1],
            a=a,
            b=other,
            related=False,
            pixels=None,
            control_points=None,
            residual_px=None,
            suite="tiny",
            place=f"tiny/{self.source_id}",
            info={"split": split, "family": "rooms", "why": "another building", "ratio": 1},
        )


@dataclass(frozen=True, kw_only=True)
class TinySuite:
    """Buildings 0, 1, ... as a suite; the one of a seed may fail."""

    name: str = "tiny"
    title: str = "Tiny: rooms"
    description: str = "Drawn rooms."
    seeds: Seeds = field(default_factory=lambda: Seeds(count=5))
    failing: int = -1

    def sources(self) -> list[Rooms]:
        seeds = range(self.seeds.first, self.seeds.first + self.seeds.count)
        return [Rooms(seed=seed, entropy=self.seeds.entropy(seed), fails=seed == self.failing) for seed in seeds]


if __name__ == "__main__":
    generate(TinySuite(), sys.argv[1], on_done=lambda pairs: print(pairs, flush=True))  # noqa: T201 - to be killed then
