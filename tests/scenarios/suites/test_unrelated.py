import numpy as np
import pytest

from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.spec import Scenario
from scenarios.suites.unrelated import MOST_SHARED, SAME_SHELL_M, SAME_WIDTH_M, corridor_m, shell
from sim.floorplans import Hall, Office, make_world
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar

pytestmark = pytest.mark.sim
BRIEF = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=180))
SHORT = MissionSpec(a=BRIEF, b=BRIEF, rays="compiled", max_seconds=60.0)
NEAR = RobotSpec(scan_hz=2.0, share=0.3, lidar=Lidar(beams=180, max_range_m=6.0))


def source(kind, **changes):
    return MissionSource("made", Scenario(name="one", kind=kind, **{"mission": SHORT, **changes}), 3)


def only_pair(from_source):
    (pair,) = from_source.pairs()
    assert (pair.related, pair.pixels, pair.control_points, pair.residual_px) == (False, None, None, None)
    assert pair.pair_id == from_source.pair_ids[0]
    assert not from_source.is_related(pair.pair_id)
    assert (pair.info["variant"], pair.info["split"]) == (from_source.scenario.kind, "test")
    return pair


def worlds(from_source, monkeypatch):
    """The buildings that a source's missions are run in, in order."""
    import scenarios.suites.unrelated as module

    made, run = [], module.run_mission
    monkeypatch.setattr(module, "run_mission", lambda world, *rest: (made.append(world), run(world, *rest))[1])
    only_pair(from_source)
    return made


def test_another_building_has_other_rooms_and_corridors_of_the_same_width(monkeypatch):
    one, other = worlds(source("other-building", other=Office(size_m=(24.0, 14.0))), monkeypatch)

    assert (one.family, other.family) == ("office", "office")
    assert abs(corridor_m(one) - corridor_m(other)) <= SAME_WIDTH_M
    assert one.size != other.size


def test_another_floor_has_the_same_shell_and_other_walls(monkeypatch):
    world = Office(wall_m=(0.15, 0.15), yaw_deg=30.0)
    one, other = worlds(source("other-floor", world=world), monkeypatch)

    assert one.size == other.size == (20.0, 13.0)
    assert np.abs(shell(one) - shell(other)).max() <= SAME_SHELL_M
    assert {tuple(room.spot) for room in one.rooms}.isdisjoint(tuple(room.spot) for room in other.rooms)


def test_another_storey_has_the_same_corridor_and_other_rooms(monkeypatch):
    one, other = worlds(source("other-storey", world=Office(yaw_deg=30.0)), monkeypatch)

    corridor, its_twin = (next(room for room in world.rooms if room.name == "corridor") for world in (one, other))
    assert np.array_equal(corridor.outline, its_twin.outline)
    assert one.to_json_dict()["walls"] != other.to_json_dict()["walls"]


def test_halls_are_blank_and_of_different_size(monkeypatch):
    halls = Hall(size_m=(12.0, 9.0), side_rooms=0), Hall(size_m=(18.0, 9.0), side_rooms=0)
    one, other = worlds(source("blank-halls", world=halls[0], other=halls[1]), monkeypatch)

    for world in (one, other):
        assert len(world.walls) == 4
        assert not world.furniture
        assert not any(world.visits)
    assert one.size != other.size


def test_maps_without_a_shared_room_have_no_floor_in_common():
    world = Office(size_m=(34.0, 14.0), rooms=12)
    apart = source(
        "no-shared-room", world=world, mission=MissionSpec(a=NEAR, b=NEAR, rays="compiled", max_seconds=60.0)
    )
    only_pair(apart)
    shared = make_pair(apart.mission(), MapSpec(), MapSpec(), 0).overlap

    assert shared is None or shared < MOST_SHARED
    log = apart.mission()
    assert set(log.a.rooms) & set(log.b.rooms) <= {"corridor"}


def test_a_mirrored_pair_is_the_missions_own_with_b_flipped():
    mirrored = source("mirrored")
    log = mirrored.mission()
    (pair,) = mirrored.pairs_of(log)
    straight = make_pair(log, MapSpec(), MapSpec(), mirrored._seed("pair"))

    assert straight.related
    assert np.array_equal(pair.a.occupancy, straight.a.occupancy)
    assert np.array_equal(pair.b.occupancy, straight.b.occupancy[:, ::-1])
    assert only_pair(mirrored).info["variant"] == "mirrored"


def test_a_building_without_corridors_has_no_width_to_compare():
    assert corridor_m(make_world(Hall(), 0)) is None
