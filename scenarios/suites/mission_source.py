"""Missions as sources of pairs: run once, mapped in every way that their scenario asks for."""

from __future__ import annotations

import functools
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rectmerge.errors import SimulationError
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import MapPair, MissionPairs, PairInputs, make_pair, make_unrelated_pair
from scenarios.suites.identifiability import LEAST_MARGIN, identifiable_margin
from scenarios.suites.spec import UNRELATED, Scenario, Variant
from scenarios.suites.unrelated import unrelated_log
from sim.floorplans import make_world
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog, cut_to_overlap

OVERLAP_WITHIN = 0.05  # of a wanted overlap
CUTS = 4  # of a log, at the most, until its finished maps have the wanted overlap
BUILDINGS = 6  # at the most, until one has every pair that is wanted


@dataclass(frozen=True, slots=True)
class MissionSource:
    """One mission to run and the pairs made from it: a `PairSource`, picklable and cheap until asked.

    Parameters
    ----------
    suite, scenario, seed
        What is wanted.
    building
        Which try it is: each is made of seeds of its own, which no other mission has.
    """

    suite: str
    scenario: Scenario
    seed: int
    building: int = 0

    @property
    def source_id(self) -> str:
        """The scenario and the seed."""
        return f"{self.scenario.name}-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """One id per variant and noise level."""
        return tuple(self._pair_id(variant, noise) for variant, noise in self._ways())

    def is_related(self, pair_id: str) -> bool:
        """Say what the scenario asks for, of every pair alike."""
        return self.scenario.kind not in UNRELATED

    def mission(self) -> MissionLog:
        """Make the building and run the mission; of unrelated maps, put A of one beside B of another."""
        if self.scenario.kind in UNRELATED:
            return unrelated_log(self.scenario, self._seed)
        world = make_world(self.scenario.world, self._seed("world"))
        return run_mission(world, self.scenario.mission, self._seed("mission"))

    def mission_pairs(self) -> MissionPairs:
        """Run the mission and make its pairs, and do so anew in another building where one of them is not to be had.

        Of six buildings at the most the first counts that gives every pair, or else the first of those that give most.

        Raises
        ------
        SimulationError
            If none gives a mission at all.
        """
        best: MissionPairs | None = None
        discarded: tuple[str, ...] = ()
        for building in range(BUILDINGS):
            there = replace(self, building=building)
            try:
                log = there.mission()
            except SimulationError as error:
                discarded += (str(error),)
                continue
            found = there.mission_pairs_from(replace(log, discarded=discarded + log.discarded))
            if not found.failed:
                return found
            discarded = found.log.discarded + tuple(found.failed.values())
            best = max((one for one in (best, found) if one), key=lambda one: len(one.pairs))
        if best is None:
            raise SimulationError(f"no mission in {BUILDINGS} buildings, the last: {discarded[-1]}")
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
        for variant, noise in self._ways():
            try:
                cut, pair = self._pair(log, variant, noise)
                pairs.append(self._told(cut, pair, variant))
                if self.scenario.kind != "mirrored":
                    spec_a, spec_b = self._specs(variant)
                    inputs[pair.pair_id] = PairInputs(log=cut, spec_a=spec_a, spec_b=spec_b)
            except SimulationError as error:
                failed[self._pair_id(variant, noise)] = str(error)
        return MissionPairs(log=log, pairs=tuple(pairs), failed=failed, inputs=inputs)

    def pairs_of(self, log: MissionLog) -> Iterator[MapPair]:
        """Give the pairs of a mission that has been run.

        Raises
        ------
        SimulationError
            After all others, if some pair cannot be had; the message says why.
        """
        return _given(self.mission_pairs_from(log))

    def pairs(self) -> Iterator[MapPair]:
        """Run the mission and give its pairs, as `explored` finds them; raises as `pairs_of` does."""
        return _given(self.mission_pairs())

    def _ways(self) -> Iterator[tuple[Variant | None, int]]:
        for variant in self.scenario.variants or (None,):
            for noise in self.scenario.noise:
                yield variant, noise

    def _pair_id(self, variant: Variant | None, noise: int) -> str:
        return "-".join((self.source_id, *([variant.name] if variant else []), f"n{noise}"))

    def _pair(self, log: MissionLog, variant: Variant | None, noise: int) -> tuple[MissionLog, MapPair]:
        """Make one pair, cut to its own overlap where it wants one; the log is cut as the pair is."""
        wanted = self.scenario.mission.overlap
        if variant is not None and variant.overlap is not None:
            wanted = variant.overlap
        if self.scenario.kind in UNRELATED or wanted is None:
            return log, self._as_it_should_be(self._made(log, variant, noise))
        if wanted != self.scenario.mission.overlap:
            log = cut_to_overlap(log.whole or log, wanted)
        pair = self._made(log, variant, noise)
        if log.whole is None:
            return log, self._as_it_should_be(pair)
        return self._recut(log, wanted, pair, variant, noise)

    def _as_it_should_be(self, pair: MapPair) -> MapPair:
        if self.scenario.kind not in UNRELATED and not pair.related:
            raise SimulationError("the maps show too few surfaces in common for a truth, wanted was a related pair")
        return pair

    def _recut(
        self, log: MissionLog, wanted: float, pair: MapPair, variant: Variant | None, noise: int
    ) -> tuple[MissionLog, MapPair]:
        aim, whole = wanted, log.whole or log
        for _ in range(CUTS):
            if _is_met(pair, wanted):
                return log, pair
            aim = min(1.0, max(0.1, aim + wanted - (pair.overlap or 0.0)))
            try:
                log = cut_to_overlap(whole, aim)
                pair = self._made(log, variant, noise)
            except SimulationError:  # the logs hold no such cut
                break
        shown = "too little in common" if pair.overlap is None else f"an overlap of {pair.overlap:.2f}"
        if not _is_met(pair, wanted):
            raise SimulationError(f"the finished maps have {shown}, wanted was {wanted:.2f}")
        return log, pair

    def _specs(self, variant: Variant | None) -> tuple[MapSpec, MapSpec]:
        return (self.scenario.a, self.scenario.b) if variant is None else (variant.a, variant.b)

    def _made(self, log: MissionLog, variant: Variant | None, noise: int) -> MapPair:
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

    def _told(self, log: MissionLog, pair: MapPair, variant: Variant | None) -> MapPair:
        """Say in a pair's info what it is of, and whether its truth can be told from other placements."""
        said: list[str] = [self.scenario.kind] if self.scenario.kind in UNRELATED else []
        said += [variant.name] if variant else []
        more: dict[str, Any] = {"variant": "-".join(said)} if said else {}
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
        if not self.building:
            return int(np.random.SeedSequence(self.seed, spawn_key=key).generate_state(1)[0])
        further = np.random.SeedSequence(self.seed, spawn_key=(*key, self.building))
        return int(further.generate_state(1, np.uint64)[0]) >> 12


def _given(explored: MissionPairs) -> Iterator[MapPair]:
    yield from explored.pairs
    if explored.failed:
        raise SimulationError("; ".join(f"{pair_id}: {why}" for pair_id, why in explored.failed.items()))


def _is_met(pair: MapPair, wanted: float) -> bool:
    return pair.overlap is not None and abs(pair.overlap - wanted) <= OVERLAP_WITHIN
