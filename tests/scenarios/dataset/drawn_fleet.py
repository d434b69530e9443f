"""A suite of drawn fleets without a simulator."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rectmerge.analysis.overlap import measure_agreement
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse
from tests.rectmerge.fleet.fleets import Fleet, fleet


@dataclass(frozen=True, kw_only=True)
class DrawnFleet:
    """Three maps of one drawn building and two of another, by the seed."""

    seed: int

    @property
    def source_id(self) -> str:
        return f"drawn-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        return tuple(f"{self.source_id}-{i}-{j}" for i, j in itertools.combinations(range(5), 2))

    def is_related(self, pair_id: str) -> bool:
        i, j = map(int, pair_id.split("-")[2:])
        return (i < 3) == (j < 3)

    def made(self) -> Fleet:
        return fleet(self.seed, home=3, other=2, side=170)

    def pairs(self) -> Iterator[MapPair]:
        made = self.made()
        names = list(made.maps)
        for (i, j), pair_id in zip(itertools.combinations(range(5), 2), self.pair_ids, strict=True):
            a, b = (made.maps[names[k]] for k in (i, j))
            pixels = made.b_to_a(names[i], names[j]) if self.is_related(pair_id) else None
            points = None
            if pixels is not None:
                at = np.random.default_rng(0).uniform(0, b.shape[0], (30, 2))
                points = np.hstack([pixels.apply(at), at])
            yield MapPair(
                pair_id=pair_id,
                a=a,
                b=b,
                related=pixels is not None,
                pixels=pixels,
                control_points=points,
                residual_px=None if pixels is None else control_point_rmse(pixels.matrix, points),
                suite="drawn",
                place=f"drawn/{self.source_id}",
                overlap=None if pixels is None else measure_agreement(a, b, pixels).overlap,
                info={
                    "fleet": self.source_id,
                    "map_a": names[i],
                    "map_b": names[j],
                    "place_a": made.place[names[i]],
                    "place_b": made.place[names[j]],
                    "is_growing": self.seed % 2 == 1,
                },
                files=(f"{self.source_id}_{i}", f"{self.source_id}_{j}"),
            )


@dataclass(frozen=True, kw_only=True)
class DrawnFleets:
    """Drawn fleets 0, 1, ... as a suite."""

    count: int = 2
    name: str = "drawn"
    title: str = "Drawn fleets"
    description: str = "Drawn buildings."

    def sources(self) -> list[DrawnFleet]:
        return [DrawnFleet(seed=seed) for seed in range(self.count)]
