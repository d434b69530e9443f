import dataclasses
from dataclasses import dataclass, field

import numpy as np
import pytest

from rectmerge.alignment import Alignment
from rectmerge.fleet import joining
from rectmerge.fleet.arranging import Arrangement, Arranger, repeated_groups
from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.evidence import Evidence
from rectmerge.fleet.many import align_many
from rectmerge.fleet.map_sample import digest
from rectmerge.fleet.params import FleetParams
from rectmerge.similarity import Similarity
from tests.rectmerge.fleet.fleets import Fleet, Oracle, fleet, members, worst_error

PARAMS = FleetParams()
ROOM_CELLS = 35.0  # from one room to the next that is like it
NAMES = ("home0", "home1", "home2", "home3")
ALIKE = 0.3  # lead that says nothing, as of rooms that are alike


@dataclass(frozen=True)
class InRows(Oracle):
    """Method that finds every placement of a row of like rooms, the true one and those next door.

    `leads` are nats by which the true one of a pair is more plausible; below 0 the next room is.
    """

    leads: dict[tuple[str, str], float] = field(default_factory=dict)

    def align(self, a, b, *, scale, rng) -> Alignment:
        names = {digest(grid): name for name, grid in self.fleet.maps.items()}
        pair = names[digest(a)], names[digest(b)]
        lead = self.leads.get(pair, self.leads.get(pair[::-1], ALIKE))
        ours, theirs = (self.fleet.poses[name] for name in pair)
        told = [
            (
                ours.inverse() @ Similarity(1.0, 0.0, rooms * ROOM_CELLS) @ theirs,
                12.0 - lead * abs(rooms) - 0.1 * (rooms < 0),
            )
            for rooms in (0, 1, -1)
        ]
        told.sort(key=lambda one: -one[1])
        return dataclasses.replace(self._answer(a, b, told), verdict="ambiguous")


@pytest.fixture
def home() -> Fleet:
    return fleet(1, home=4, other=0)


CLEAR = [("home0", "home1"), ("home1", "home2"), ("home2", "home3"), ("home0", "home2")]
LEADS = {**dict.fromkeys(CLEAR, 1.5), ("home1", "home3"): 0.7, ("home0", "home3"): 0.7}


def test_maps_that_no_join_decides_are_arranged_where_most_pairs_agree(home, monkeypatch):
    graph = align_many(home.maps, method=InRows(home, leads=LEADS))
    monkeypatch.setattr(joining, "repeated_groups", lambda *_: [])
    without = align_many(home.maps, method=InRows(home, leads=LEADS))

    assert members(graph) == {frozenset(NAMES)} != members(without)
    assert worst_error(home, graph) < 0.02
    assert min(placement.confidence for placement in graph.placements.values()) >= 0.85


def test_the_order_of_the_maps_changes_no_arrangement(home):
    graphs = [
        align_many({name: home.maps[name] for name in order}, method=InRows(home, leads=LEADS))
        for order in (NAMES, NAMES[::-1])
    ]
    of_two = [graph.placements["home3"].pixels.inverse() @ graph.placements["home0"].pixels for graph in graphs]

    assert members(graphs[0]) == members(graphs[1])
    np.testing.assert_allclose(of_two[0].apply([[0, 0], [100, 50]]), of_two[1].apply([[0, 0], [100, 50]]), atol=1e-6)


def test_maps_of_rooms_that_are_all_alike_stay_apart(home):
    assert not align_many(home.maps, method=InRows(home)).components


def arranger(values: list[float]) -> tuple[Arranger, list[Arrangement]]:
    return Arranger(Evidence([], PARAMS.evidence, lambda *_: 0.0), [], PARAMS), [
        Arrangement({(0,): ComplexSimilarity()}, value) for value in values
    ]


@pytest.mark.parametrize(
    ("nats", "odds"),
    [
        ([], -np.inf),
        ([3.0], 3.0),  # no rival: against none
        ([9.0, 3.0], 6.0 - PARAMS.arrange.margin),
        ([9.0, 3.0, 3.0], 6.0 - np.log(2.0) - PARAMS.arrange.margin),
        ([-2.0, -20.0], -2.0),  # the best of what nothing speaks for
    ],
)
def test_an_arrangement_is_weighed_against_all_others_and_none(nats, odds):
    judge, found = arranger(nats)

    assert judge.log_odds(found) == pytest.approx(odds)


def test_components_are_grouped_by_the_pairs_that_repeat():
    components = [(0, 4), (1,), (2,), (3,)]

    assert repeated_groups(components, {(1, 4), (2, 3)}) == [[(0, 4), (1,)], [(2,), (3,)]]
    assert repeated_groups(components, {(0, 4)}) == []
