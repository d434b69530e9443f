"""Missions as sources of pairs: run once, mapped in every way that their scenario asks for."""

from __future__ import annotations

import functools
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from rectmerge.errors import SimulationError
from scenarios.corruption import NoiseLevel
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import MapPair, MissionPairs, PairInputs, make_pair, make_unrelated_pair
from scenarios.suites.identifiability import LEAST_MARGIN, identifiable_margin
from scenarios.suites.spec import UNRELATED, Scenario, Variant
from scenarios.suites.unrelated import unrelated_log
from sim.floorplans import make_world
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog, cut_to_overlap

OVERLAP_TOLERANCE = 0.05  # of a wanted overlap
MAX_CUTS = 4  # of a log, for maps of the wanted overlap
MAX_BUILDINGS = 6  # attempts at every wanted pair


@dataclass(frozen=True, slots=True)
class MissionSource:
    """One mission to run and its pairs: a `PairSource`, picklable and cheap until `pairs` is called.

    Parameters
    ----------
    suite, scenario, seed
        Suite's name, scenario and seed of the mission.
    building
        Number of the attempt; each has seeds of its own.
    version
        The suite's: rows of another version are other rows.
    """

    suite: str
    scenario: Scenario
    seed: int
    building: int = 0
    version: int = 1

    @property
    def source_id(self) -> str:
        """Name of the scenario, and the seed."""
        return f"{self.scenario.name}-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """One id per variant and noise level."""
        return tuple(self._pair_id(variant, noise) for variant, noise in self._variants())

    def is_related(self, pair_id: str) -> bool:
        """Return whether the scenario asks for related maps, the same for every pair."""
        return self.scenario.kind not in UNRELATED

    def mission(self) -> MissionLog:
        """Make the building and run the mission; of unrelated maps, join A of one mission with B of another."""
        if self.scenario.kind in UNRELATED:
            return unrelated_log(self.scenario, self._seed)
        world = make_world(self.scenario.world, self._seed("world"))
        return run_mission(world, self.scenario.mission, self._seed("mission"))

    def mission_pairs(self) -> MissionPairs:
        """Run the mission and make its pairs, again in another building where a pair fails.

        The first of at most six buildings that gives every pair counts, else the first of those that give most.

        Raises
        ------
        SimulationError
            If none gives a mission at all.
        """
        best: MissionPairs | None = None
        discarded: tuple[str, ...] = ()
        for building in range(MAX_BUILDINGS):
            attempt = replace(self, building=building)
            try:
                log = attempt.mission()
            except SimulationError as error:
                discarded += (str(error),)
                continue
            mission = attempt.mission_pairs_from(replace(log, discarded=discarded + log.discarded))
            if not mission.failed:
                return mission
            discarded = mission.log.discarded + tuple(mission.failed.values())
            best = max((pairs for pairs in (best, mission) if pairs), key=lambda pairs: len(pairs.pairs))
        if best is None:
            raise SimulationError(f"no mission in {MAX_BUILDINGS} buildings, the last: {discarded[-1]}")
        return replace(best, log=replace(best.log, discarded=discarded))

    def mission_pairs_from(self, log: MissionLog) -> MissionPairs:
        """Make the pairs of a mission that has been run.

        Noise and wrong poses change what a map shows: where a wanted overlap is missed by more than 0.05, the logs are
        cut anew for a little more or less. Where no cut gives finished maps of the wanted overlap, the reason says what
        they have.
        """
        pairs: list[MapPair] = []
        failed: dict[str, str] = {}
        inputs: dict[str, PairInputs] = {}
        for variant, noise in self._variants():
            try:
                cut, pair = self._pair(log, variant, noise)
                pairs.append(self._described(cut, pair, variant))
                if self.scenario.kind != "mirrored":
                    spec_a, spec_b = self._specs(variant)
                    inputs[pair.pair_id] = PairInputs(log=cut, spec_a=spec_a, spec_b=spec_b)
            except SimulationError as error:
                failed[self._pair_id(variant, noise)] = str(error)
        return MissionPairs(log=log, pairs=tuple(pairs), failed=failed, inputs=inputs)

    def pairs_of(self, log: MissionLog) -> Iterator[MapPair]:
        """Yield the pairs of a mission that has been run.

        Raises
        ------
        SimulationError
            After all others, if a pair fails; the message has the reason.
        """
        return _yield_pairs(self.mission_pairs_from(log))

    def pairs(self) -> Iterator[MapPair]:
        """Run the mission and yield its pairs, as `mission_pairs` finds them; raises as `pairs_of` does."""
        return _yield_pairs(self.mission_pairs())

    def _variants(self) -> Iterator[tuple[Variant | None, NoiseLevel]]:
        for variant in self.scenario.variants or (None,):
            for noise in self.scenario.noise:
                yield variant, noise

    def _pair_id(self, variant: Variant | None, noise: NoiseLevel) -> str:
        return "-".join((self.source_id, *([variant.name] if variant else []), f"n{noise}"))

    def _pair(self, log: MissionLog, variant: Variant | None, noise: NoiseLevel) -> tuple[MissionLog, MapPair]:
        """Make one pair, cut to its own overlap where it wants one; the log is cut as the pair is."""
        wanted = self.scenario.mission.overlap
        if variant is not None and variant.overlap is not None:
            wanted = variant.overlap
        if self.scenario.kind in UNRELATED or wanted is None:
            return log, self._require_related(self._make(log, variant, noise))
        if wanted != self.scenario.mission.overlap:
            log = cut_to_overlap(log.whole or log, wanted)
        pair = self._make(log, variant, noise)
        if log.whole is None:
            return log, self._require_related(pair)
        return self._recut(log, wanted, pair, variant, noise)

    def _require_related(self, pair: MapPair) -> MapPair:
        if self.scenario.kind not in UNRELATED and not pair.related:
            raise SimulationError("the maps show too few surfaces in common for a truth, wanted was a related pair")
        return pair

    def _recut(
        self, log: MissionLog, wanted: float, pair: MapPair, variant: Variant | None, noise: NoiseLevel
    ) -> tuple[MissionLog, MapPair]:
        aim, whole = wanted, log.whole or log
        for _ in range(MAX_CUTS):
            if _is_met(pair, wanted):
                return log, pair
            aim = min(1.0, max(0.1, aim + wanted - (pair.overlap or 0.0)))
            try:
                log = cut_to_overlap(whole, aim)
                pair = self._make(log, variant, noise)
            except SimulationError:  # the logs hold no such cut
                break
        shown = "too little in common" if pair.overlap is None else f"an overlap of {pair.overlap:.2f}"
        if not _is_met(pair, wanted):
            raise SimulationError(f"the finished maps have {shown}, wanted was {wanted:.2f}")
        return log, pair

    def _specs(self, variant: Variant | None) -> tuple[MapSpec, MapSpec]:
        return (self.scenario.a, self.scenario.b) if variant is None else (variant.a, variant.b)

    def _make(self, log: MissionLog, variant: Variant | None, noise: NoiseLevel) -> MapPair:
        make: Callable[..., MapPair] = make_pair
        if self.scenario.kind in UNRELATED:
            make = functools.partial(make_unrelated_pair, is_mirrored=self.scenario.kind == "mirrored")
        return make(
            log,
            *self._specs(variant),
            self._seed("pair"),
            noise=noise,
            pair_id=self._pair_id(variant, noise),
            suite=self.suite,
            place=f"{self.suite}/{self.source_id}",
        )

    def _described(self, log: MissionLog, pair: MapPair, variant: Variant | None) -> MapPair:
        """Add the variant, the split and the identifiability to a pair's info."""
        names: list[str] = [self.scenario.kind] if self.scenario.kind in UNRELATED else []
        names += [variant.name] if variant else []
        more: dict[str, Any] = {"suite_version": self.version}
        more |= {"variant": "-".join(names)} if names else {}
        if pair.related:
            margin = identifiable_margin(log, pair)
            more |= {"identifiable_margin": margin, "identifiable": margin >= LEAST_MARGIN}
        return replace(pair, info={**pair.info, "split": self.scenario.split, **more})

    def _seed(self, purpose: str) -> int:
        """Derive a seed that scenarios, purposes and buildings do not share.

        The first building's has 32 bits. The many further ones have 52, so that none meets that of another split; more
        a number in JSON does not keep.
        """
        key = tuple(zlib.crc32(text.encode()) for text in (self.scenario.name, purpose))
        seeds = self.scenario.seeds
        if not self.building:
            return seeds.derive(self.seed, key)
        return seeds.derive(self.seed, (*key, self.building), is_wide=True)


def _yield_pairs(mission: MissionPairs) -> Iterator[MapPair]:
    yield from mission.pairs
    if mission.failed:
        raise SimulationError("; ".join(f"{pair_id}: {reason}" for pair_id, reason in mission.failed.items()))


def _is_met(pair: MapPair, wanted: float) -> bool:
    return pair.overlap is not None and abs(pair.overlap - wanted) <= OVERLAP_TOLERANCE
