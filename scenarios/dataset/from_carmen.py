"""Pairs of maps from one robot's real log: cut in two at a time, each part mapped as if by a robot of its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from rectmerge.errors import InputError, SimulationError
from scenarios.dataset.generate import SEED_STRIDE
from scenarios.pairs.map_view import MapSpec, PlacedMap, place_map
from scenarios.pairs.pair import MapPair, map_attributes, pair_from_maps
from scenarios.pairs.truth import ScannedSurface, common_points
from sim.importers.survey import Survey
from sim.missions.mission_log import RobotLog

CUTS_WITHIN = 0.2  # of the wanted cut, as a share of the scans, lie the cuts of several pairs
MARGIN = 0.1  # of the scans, that each part has at least


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CutSource:
    """One pair cut from a survey: a `PairSource`.

    Parameters
    ----------
    suite, number, seed
        Names the pair, and what is drawn for it.
    survey
        The whole log.
    cut, shared
        As in `CarmenSuite`.
    specs
        How the maps of both parts are made; `poses` says nothing here.
    """

    suite: str
    number: int
    seed: int
    survey: Survey = field(repr=False)
    cut: float
    shared: float
    specs: tuple[MapSpec, MapSpec]

    @property
    def source_id(self) -> str:
        """The log's name and the number."""
        return f"{self.suite}-{self.number:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """The one pair."""
        return (self.source_id,)

    def is_related(self, pair_id: str) -> bool:
        """Return True: both parts are of one log."""
        return True

    def pairs(self) -> Iterator[MapPair]:
        """Map both parts, and find their common surface points.

        Raises
        ------
        InputError
            If a part has too few scans.
        SimulationError
            If both maps show fewer than 20 surface cells in common.
        """
        of_a, of_b, of_points = np.random.SeedSequence(self.seed).spawn(3)
        (part_a, part_b), lidar = self._parts(), self.survey.lidar
        a, b = self._placed(part_a, self.specs[0], of_a), self._placed(part_b, self.specs[1], of_b)
        seen_a, seen_b = ScannedSurface.from_log(part_a, lidar, a), ScannedSurface.from_log(part_b, lidar, b)
        points = common_points(seen_a, seen_b, np.random.default_rng(of_points))
        if points is None:
            raise SimulationError(
                f"the parts before and after {self.cut:.2f} of the log show too few surfaces in common for a truth: "
                "cut elsewhere (--cut) or let both have some scans (--shared)"
            )
        yield pair_from_maps(
            a,
            b,
            points,
            pair_id=self.source_id,
            suite=self.suite,
            place=f"carmen/{self.suite}",
            info=self._info(a, b),
        )

    def _parts(self) -> tuple[RobotLog, RobotLog]:
        count = len(self.survey.robot.times)
        middle, more = round(self.cut * count), round(self.shared * count / 2)
        return self.survey.part(0, middle + more), self.survey.part(middle - more, count)

    def _placed(self, part: RobotLog, spec: MapSpec, seed: np.random.SeedSequence) -> PlacedMap:
        return place_map(part, self.survey.lidar, spec, noise=0, seed=seed, scan_poses=self.survey.map_poses(part))

    def _info(self, a: PlacedMap, b: PlacedMap) -> dict[str, object]:
        source = "slam" if self.survey.is_matched else "log"
        of_maps = {**map_attributes("a", a, self.specs[0]), **map_attributes("b", b, self.specs[1])}
        sources = dict.fromkeys(("pose_source", "pose_source_a", "pose_source_b"), source)
        more = {"family": "carmen", "seed": self.seed, "noise": 0, "cut": self.cut, "shared": self.shared}
        return {**more, **of_maps, **sources, "split": "test"}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarmenSuite:
    """Pairs cut from one log: a suite for `scenarios.dataset.generate.generate`.

    Parameters
    ----------
    name
        Of the log.
    survey
        The log.
    pairs
        How many.
    cut
        Where the log is cut, as a share of its scans that moved on: A has those before, B those after. The cuts of
        several pairs are spread evenly over 0.2 to either side.
    shared
        Share of the scans, around the cut, that both have.
    resolution_a, resolution_b
        Metres per cell, hidden from methods.
    seed
        Of turns and grid phases.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    name: str
    survey: Survey = field(repr=False)
    pairs: int = 1
    cut: float = 0.5
    shared: float = 0.0
    resolution_a: float = 0.05
    resolution_b: float = 0.05
    seed: int = 0

    def __post_init__(self) -> None:
        if self.pairs < 1 or self.seed < 0 or self.pairs > SEED_STRIDE:
            raise InputError(f"pairs must be 1 to {SEED_STRIDE} and seed >= 0, got {self.pairs} and {self.seed}")
        if not MARGIN <= self.cut <= 1 - MARGIN:
            raise InputError(f"cut must be {MARGIN} to {1 - MARGIN} of the log, got {self.cut}")
        if not 0 <= self.shared <= 1:
            raise InputError(f"shared must be 0 to 1 of the log, got {self.shared}")
        self._specs()

    @property
    def title(self) -> str:
        """A few words."""
        return f"Pairs cut from the log {self.name}"

    @property
    def description(self) -> str:
        """Description for the card."""
        poses = "our scan matching with loop closure" if self.survey.is_matched else "the log's own poses"
        alone = "its scans matched anew without the other part's" if self.survey.is_matched else "by those poses"
        return (
            "One robot's log cut in two, each part mapped as if by a robot of its own. The truth is where the whole "
            f"log puts the surfaces that both parts hit, by {poses}: as good as those are. Each map is made of one "
            f"part alone, {alone}."
        )

    def sources(self) -> list[CutSource]:
        """Return one source per pair."""
        return [
            CutSource(
                suite=self.name,
                number=number,
                seed=self.seed * SEED_STRIDE + number,
                survey=self.survey,
                cut=cut,
                shared=self.shared,
                specs=self._specs(),
            )
            for number, cut in enumerate(self._cuts())
        ]

    def _specs(self) -> tuple[MapSpec, MapSpec]:
        a, b = (MapSpec(resolution=cell_m, turn_deg="random") for cell_m in (self.resolution_a, self.resolution_b))
        return a, b

    def _cuts(self) -> list[float]:
        if self.pairs == 1:
            return [self.cut]
        low, high = max(MARGIN, self.cut - CUTS_WITHIN), min(1 - MARGIN, self.cut + CUTS_WITHIN)
        return [round(float(cut), 6) for cut in np.linspace(low, high, self.pairs)]
