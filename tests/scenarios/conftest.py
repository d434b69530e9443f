"""What several tests of the benchmark need."""

import pytest


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
