import json

import pytest

from rectmerge.errors import InputError
from scenarios.leaderboard.growth import write_growth


def measured(path, benches):
    record = {
        "machine_info": {"cpu": {"brand_raw": "a processor"}, "python_version": "3.11"},
        "commit_info": {"id": "0123456789abcdef"},
        "benchmarks": [
            {"extra_info": {"what": what, "side": side, **dict(more)}, "stats": {"min": seconds}}
            for what, side, seconds, *more in benches
        ],
    }
    path.write_text(json.dumps(record))
    return path


@pytest.mark.slow
def test_the_page_tells_times_and_the_power_of_the_cells(tmp_path):
    benches = [
        ("linear", 400, 0.01, ("verdict", "accepted")),
        ("linear", 800, 0.04, ("verdict", "ambiguous"), ("peak_mb", 123.4)),
        ("flat", 400, 0.2),
        ("flat", 800, 0.2),
        ("one", 400, 1.0),
    ]

    write_growth(measured(tmp_path / "b.json", benches), tmp_path / "out")

    text = (tmp_path / "out/README.md").read_text()
    assert "| linear | 0.010 | 0.040 no | 1.00 |" in text
    assert "| peak memory of the command | - | 123 MB | - |" in text
    assert "| flat | 0.200 | 0.200 | 0.00 |" in text.replace("-0.00", "0.00")
    assert "| one | 1.000 | - | - |" in text
    assert "a processor, Python 3.11; commit 0123456789ab." in text
    assert "</svg>" in (tmp_path / "out/growth.svg").read_text()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"benchmarks": []}'])
def test_what_is_no_measurement_is_refused(tmp_path, content):
    (tmp_path / "b.json").write_text(content)

    with pytest.raises(InputError, match=r"b\.json: .*bench_growth\.py; make one with: pytest "):
        write_growth(tmp_path / "b.json", tmp_path / "out")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(
        InputError, match=r"none\.json: cannot be read: No such file or directory; make one with: pytest "
    ):
        write_growth(tmp_path / "none.json", tmp_path / "out")
