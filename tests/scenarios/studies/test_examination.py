import pytest

from scenarios.studies.examination import examine_mission
from scenarios.suites.random_missions import random_sources


@pytest.mark.sim
def test_a_mission_is_examined_whole():
    finding = examine_mission(random_sources(2)[1])

    assert finding.failure or finding.measures["overlap"] == pytest.approx(finding.wanted_overlap, abs=0.05)
    assert not finding.faults
    assert not finding.is_crash
