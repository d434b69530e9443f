from tests.bench.ratios import comparison, release_record, yardstick_seconds


def measured(seconds, yardstick=0.02):
    return {
        "benchmarks": [
            {"fullname": f"tests/bench/{name}", "stats": {"min": least}, "extra_info": {"yardstick_s": yardstick}}
            for name, least in seconds.items()
        ],
        "machine_info": {"cpu": {"brand_raw": "A processor"}, "python_version": "3.11.7"},
        "commit_info": {"id": "0123456789abcdef"},
    }


def test_a_machine_half_as_fast_has_the_same_ratios():
    fast, slow = (release_record(measured({"one": 0.1 * k, "two": 0.4 * k}, 0.02 * k)) for k in (1, 2))

    assert fast["ratios"] == slow["ratios"] == {"one": 5.0, "two": 20.0}
    assert comparison(slow, fast)[1] == []


def test_only_what_grew_too_far_is_slower_and_new_benches_are_shown():
    old = release_record(measured({"one": 0.1, "two": 0.4, "gone": 1.0}))
    new = release_record(measured({"one": 0.12, "two": 0.6, "fresh": 1.0}))

    table, slower = comparison(new, old)

    assert slower == ["two"]
    assert "| one | 5 | 6 | 1.2 |" in table
    assert "| fresh | - | 50 | - |" in table
    assert "| gone | 50 | - | - |" in table


def test_the_yardstick_takes_time():
    assert yardstick_seconds(rounds=1) > 0
