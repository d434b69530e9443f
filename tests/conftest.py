"""Settings of the whole suite."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# The first example of a property may compile a kernel, and the machine may be busy: time says nothing here. Where CI is
# set, as CI systems do, the examples are the same in every run, so that it judges the change and not the luck.
settings.register_profile("compiled", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.register_profile("fast", deadline=None, max_examples=20)  # `make test-fast`
settings.register_profile("long", deadline=None, max_examples=2000)  # `make fuzz`
settings.load_profile("compiled")

HERE = Path(__file__).parent
LONGEST = {
    HERE / name
    for name in (
        "scenarios/studies/test_accuracy.py",
        "scenarios/bench/test_resume.py",
        "scenarios/execution/test_executors.py",
        "test_wheel.py",
        "test_snippets.py",
    )
}


def pytest_collection_modifyitems(items):
    """Let the processes of `make test` begin with the files that take longest: the last works alone."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: item.path not in LONGEST)


@pytest.fixture
def dask_cluster():
    """A cluster of two workers on this machine."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": ":0"},  # its HTTP server: tests in another process may have the port
        silence_logs=50,
    ) as opened:
        yield opened
