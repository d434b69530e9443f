from scenarios.studies.examination import Finding
from scenarios.studies.realism_page import coverage, distributions, page, robustness

MACHINE = {"commit": "abc", "processor": "a processor"}


def test_the_page_tells_what_lies_where_the_simulated_pairs_lie_and_what_failed():
    pairs = [
        Finding(
            origin="hall",
            measures={"overlap": k / 10, "wall_cells": 2.0, "speckle": 0.01},
            wanted_overlap=0.5,
            discarded=1,
        )
        for k in range(1, 10)
    ]
    findings = [*pairs, Finding(origin="loop", failure="no way"), Finding(origin="loop", failure="bang", is_crash=True)]
    real = {
        "real_maps": [
            Finding(origin="real_maps", measures={"overlap": 0.5}),
            Finding(origin="x", measures={"overlap": 2}),
        ]
    }

    assert "| overlap | real_maps | 1 of 2 |" in coverage({"simulated": findings, **real})
    assert "| overlap | simulated | 9 | 0.14 |" in distributions({"simulated": findings, **real})
    table = robustness(findings)
    assert "| missions run | 11 |" in table
    assert "| crashes | 1 |" in table
    assert "| tries discarded before one succeeded | 9 |" in table
    text = page(findings, real, MACHINE)
    assert "- loop: bang" in text
    assert "- loop: no way" in text
