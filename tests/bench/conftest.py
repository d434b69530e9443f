"""Shows beneath the times what each bench noted of itself in `benchmark.extra_info`: ratios, sizes, memory."""

import pytest


@pytest.fixture(autouse=True)
def noted(request, benchmark):
    yield
    request.node.user_properties += benchmark.extra_info.items()


def pytest_terminal_summary(terminalreporter):
    torn_down = [report for report in terminalreporter.getreports("") if report.when == "teardown"]
    if noted := [report for report in torn_down if report.user_properties]:
        terminalreporter.section("noted")
    for report in noted:
        figures = (f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in report.user_properties)
        terminalreporter.write_line(f"{report.nodeid.rpartition('::')[2]}: {', '.join(figures)}")
