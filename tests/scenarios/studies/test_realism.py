from dataclasses import replace

import numpy as np
import pytest

from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.studies.realism import Finding, affine_rmse, examine, faults_of, figures_of, goes_through_walls
from scenarios.studies.realism_page import coverage, distributions, page, sturdiness
from scenarios.suites.random_missions import random_sources
from sim.missions.mission_log import MissionLog
from tests.sim.small_worlds import office_log

MACHINE = {"commit": "abc", "processor": "a processor"}


def standing(log: MissionLog, seconds: float, note: str = "") -> MissionLog:
    """The log of a robot A that stands where it was first."""
    poses = np.repeat(log.a.poses[:1], len(log.a.times), axis=0)
    return replace(log, a=replace(log.a, poses=poses, times=np.linspace(0, seconds, len(poses)), note=note))


def test_what_an_affine_map_removes_is_all_of_a_stretch_and_none_of_nothing():
    log = office_log()
    straight = make_pair(log, MapSpec(), MapSpec(), 3)
    stretched = make_pair(log, MapSpec(), MapSpec(corruption=(("stretch", 5.0),)), 3)

    assert "affine" not in figures_of(straight)
    found = figures_of(stretched)
    assert found["residual"] > 0.003
    assert found["affine"] > 0.99
    assert affine_rmse(stretched.control_points) < 1e-6
    assert 0.3 < found["overlap"] <= 1.0
    assert found["wall_cells"] > 0.5


def test_a_robot_that_crosses_a_wall_is_found_out():
    log = office_log()
    door_to_door = replace(log.a, poses=log.a.poses[[0, 0]], times=log.a.times[:2])
    out = np.add(door_to_door.poses, [[0, 0, 0], [log.world.size[0], 0, 0]])

    assert not goes_through_walls(log.world, door_to_door, 0)
    inside = np.clip(out, 0.0, [*log.world.size, np.inf]) - [0.01, 0.0, 0.0]
    assert goes_through_walls(log.world, replace(door_to_door, poses=inside), 0)


def test_a_robot_that_stands_still_has_to_say_so():
    log = office_log()
    faults = faults_of(standing(log, 40.0))

    assert any("did not say so" in fault for fault in faults)
    assert not any(
        "did not say so" in fault and "A" in fault for fault in faults_of(standing(log, 40.0, "no progress"))
    )


def test_the_page_tells_what_lies_where_the_simulated_pairs_lie_and_what_failed():
    made = [
        Finding(kind="hall", figures={"overlap": k / 10, "wall_cells": 2.0, "speckle": 0.01}, wanted=0.5, discarded=1)
        for k in range(1, 10)
    ]
    findings = [*made, Finding(kind="loop", failure="no way"), Finding(kind="loop", failure="bang", is_crash=True)]
    real = {
        "real_maps": [Finding(kind="real_maps", figures={"overlap": 0.5}), Finding(kind="x", figures={"overlap": 2})]
    }

    assert "| overlap | real_maps | 1 of 2 |" in coverage({"simulated": findings, **real})
    assert "| overlap | simulated | 9 | 0.14 |" in distributions({"simulated": findings, **real})
    told = sturdiness(findings)
    assert "| missions run | 11 |" in told
    assert "| crashes | 1 |" in told
    assert "| tries discarded before one succeeded | 9 |" in told
    whole = page(findings, real, MACHINE)
    assert "- loop: bang" in whole
    assert "- loop: no way" in whole


@pytest.mark.sim
def test_a_mission_is_examined_whole():
    finding = examine(random_sources(2)[1])

    assert finding.failure or finding.figures["overlap"] == pytest.approx(finding.wanted, abs=0.05)
    assert not finding.faults
    assert not finding.is_crash
