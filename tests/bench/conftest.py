"""The yardstick before each bench, and beneath the times each bench's `benchmark.extra_info`: ratios, sizes, memory."""

import pytest

from tests.bench.ratios import yardstick_seconds

YARDSTICK = "yardstick_s"  # of the same run, just before: machines and minutes differ, ratios hardly


@pytest.fixture(autouse=True)
def noted(request, benchmark):
    benchmark.extra_info[YARDSTICK] = yardstick_seconds()
    yield
    request.node.user_properties += [item for item in benchmark.extra_info.items() if item[0] != YARDSTICK]


def pytest_terminal_summary(terminalreporter):
    torn_down = [report for report in terminalreporter.getreports("") if report.when == "teardown"]
    if noted := [report for report in torn_down if report.user_properties]:
        terminalreporter.section("noted")
    for report in noted:
        figures = (f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in report.user_properties)
        terminalreporter.write_line(f"{report.nodeid.rpartition('::')[2]}: {', '.join(figures)}")
