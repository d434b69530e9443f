"""Shows beneath the times what each bench noted of itself in `benchmark.extra_info`: ratios, sizes, memory."""

import pytest


@pytest.fixture(autouse=True)
def noted(request, benchmark):
    yield
    request.node.user_properties += benchmark.extra_info.items()


def pytest_terminal_summary(terminalreporter):
    terminalreporter.section("noted")
    for report in terminalreporter.getreports(""):  # of set-ups and teardowns
        if report.when == "teardown" and report.user_properties:
            figures = (f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in report.user_properties)
            terminalreporter.write_line(f"{report.nodeid.rpartition('::')[2]}: {', '.join(figures)}")
