"""A dask cluster as the place where pairs are aligned, for commands that take the address of its scheduler."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from typing import Any

from rectmerge.errors import InputError
from rectmerge.extras import require_extras

REACHED_WITHIN_S = 10.0  # a cluster, and its first worker


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Open a dask cluster by its scheduler's address; yield it with the number of its workers' threads.

    Raises
    ------
    InputError
        If `distributed` is not installed, nobody answers at the address, or the cluster has no worker.
    BrokenExecutor
        If a task kept killing the workers, and nobody else has taken care of it.
    """
    require_extras("distributed")
    import distributed

    try:
        client: Any = distributed.Client(address, timeout=REACHED_WITHIN_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError):
        raise InputError(f"--cluster {address}: no dask scheduler answers there") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=REACHED_WITHIN_S)
        except TimeoutError:
            raise InputError(f"--cluster {address}: the cluster has no worker") from None
        executor, done = client.get_executor(pure=False), False
        try:
            yield executor, sum(client.nthreads().values())
            done = True
        except distributed.KilledWorker as error:
            raise BrokenExecutor(str(error)) from error
        finally:
            executor.shutdown(wait=done)
