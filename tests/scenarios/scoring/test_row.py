from scenarios.scoring.row import versions_line


def test_the_versions_of_simulated_suites_are_named_and_real_pairs_have_none():
    rows = [
        {"suite": "trust", "info": {"noise": 1}},
        {"suite": "standard", "info": {"noise": 2, "suite_version": 2}},
        {"suite": "standard", "info": {"noise": 1, "suite_version": 2}},
        {"suite": "real_maps", "info": {"variant": "sensor"}},
        {"suite": "smoke", "info": None},
    ]

    assert versions_line(rows).startswith("Suites: `standard` version 2, `trust` version 1. Noise 1 to 3 is even noise")
    assert versions_line(rows[3:]) == ""
