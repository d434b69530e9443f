"""Executors of tasks: this process, local workers or a cluster, with detection of tasks that kill their workers."""

from __future__ import annotations

import functools
import multiprocessing
import os
import platform
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from importlib import metadata
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from rectmerge.cli.cluster import cluster
from rectmerge.errors import InputError, RectMergeError
from scenarios.execution.attempt import memory_mb
from scenarios.execution.limits import DEATHS, describe_exit, die_with

P = ParamSpec("P")
T = TypeVar("T")
Item = TypeVar("Item")
IN_FLIGHT = 64  # tasks handed to an executor at a time, unless it is known how many it works on at once:
TASKS_PER_WORKER = 2  # few, for all that a dying worker holds are suspects
RECYCLE_AFTER = 64  # tasks per worker,
GROWN_MB = 1000.0  # and this much memory: a worker that loads many worlds grows
ENDED_WITHIN_S = 1.0  # a worker of a broken pool


class WorkerDiedError(RectMergeError):
    """Death of a worker process in the middle of a task; `out_of_memory` if the system killed it."""

    def __init__(self, status: int | None) -> None:
        self.out_of_memory = status == -signal.SIGKILL
        why = "died" if status is None else describe_exit(status)
        super().__init__(f"the worker process {why}, {DEATHS} times")


class LocalPool(Executor):
    """The standard process pool, replaced when it broke or its workers have grown.

    Parameters
    ----------
    count
        How many processes, > 0.

    Notes
    -----
    The standard pool's `max_tasks_per_child` does not do: before Python 3.14 it ends up without workers and waits for
    ever when more tasks are queued than there are workers.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._new_pool()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Queue a task; function and arguments must be picklable."""
        grown = self._submitted >= RECYCLE_AFTER * self._count and any(
            memory_mb(worker.pid or 0) > GROWN_MB for worker in self._workers.values()
        )
        if grown:
            self._pool.shutdown()
            self._new_pool()
        self._submitted += 1
        with _no_interrupts():
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenExecutor:
                self._new_pool()
                return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop the workers; without `wait`, in the middle of their tasks."""
        if not wait:
            for worker in list(self._workers.values()):
                worker.kill()
        self._pool.shutdown(wait=True, cancel_futures=cancel_futures or not wait)

    @property
    def status(self) -> int | None:
        """Return the exit status of the worker that broke the pool; the pool then ended the others with SIGTERM."""
        ends = time.monotonic() + ENDED_WITHIN_S
        while None in (ended := {worker.exitcode for worker in self._workers.values()}) and time.monotonic() < ends:
            time.sleep(0.01)
        return next((status for status in ended if status not in (None, -signal.SIGTERM)), None)

    def _new_pool(self) -> None:
        resource_tracker.ensure_running()  # which unblocks the signals that `_no_interrupts` blocks
        context = multiprocessing.get_context("spawn")  # a fork would copy locks and the physics engine's state
        self._pool = ProcessPoolExecutor(self._count, context, initializer=die_with, initargs=(os.getpid(),))
        self._workers: Mapping[int, BaseProcess] = self._pool._processes  # no public way until Python 3.14
        self._submitted = 0


@contextmanager
def local_workers(count: int) -> Iterator[LocalPool | None]:
    """Open worker processes, None for one; if the body fails they are stopped at once."""
    executor = LocalPool(count) if count > 1 else None
    done = False
    try:
        yield executor
        done = True
    finally:
        if executor:
            executor.shutdown(wait=done)


@contextmanager
def workplace(workers: int, address: str | None) -> Iterator[tuple[Executor | None, int]]:
    """Open a cluster if there is an address, else local workers; yield it with the number of tasks in flight."""
    if address is not None:
        with cluster(address) as (executor, threads):
            yield executor, TASKS_PER_WORKER * threads
    else:
        with local_workers(workers) as pool:
            yield pool, TASKS_PER_WORKER * workers


def completed(
    executor: Executor | None, fn: Callable[[Item], T], items: Iterable[Item], *, in_flight: int = IN_FLIGHT
) -> Iterator[tuple[Item, Future[T]]]:
    """Do `fn` on every item and yield each item with its finished future, as they end.

    A worker that dies costs the tasks in flight: they are done again alone, and one whose worker died three times
    fails with `WorkerDiedError`.

    Parameters
    ----------
    executor
        Where the work is done; None is this process, one item after the other.
    fn
        The work; picklable where the executor needs it.
    items
        What to do it on; taken one by one, as there is room.
    in_flight
        How many tasks are handed to the executor at a time.
    """
    if executor is None:
        yield from ((item, _done_here(fn, item)) for item in items)
        return
    waiting, running, suspects = iter(items), dict[Future[T], Item](), list[Item]()
    while True:
        if not suspects:
            running |= {executor.submit(fn, item): item for item in islice(waiting, in_flight - len(running))}
        if not running and not suspects:
            return
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            item = running.pop(future)
            if _has_died(future):
                suspects.append(item)
            else:
                yield item, future
        if not running:
            yield from ((item, _done_alone(executor, fn, item)) for item in suspects)
            suspects = []


def _done_here(fn: Callable[[Item], T], item: Item) -> Future[T]:
    """Do one item in this process; its future raises its error, an interrupt is raised at once."""
    done: Future[T] = Future()
    try:
        done.set_result(fn(item))
    except Exception as error:  # noqa: BLE001 - whoever takes the future's result gets it raised
        done.set_exception(error)
    return done


def _done_alone(executor: Executor, fn: Callable[[Item], T], item: Item) -> Future[T]:
    """Run a suspected task alone, at most two more times, and fail it if its worker dies each time."""
    for _ in range(DEATHS - 1):
        future = executor.submit(fn, item)
        wait([future])
        if not _has_died(future):
            return future
        if _is_given_up(future.exception()):
            break
    failed: Future[T] = Future()
    failed.set_exception(WorkerDiedError(executor.status if isinstance(executor, LocalPool) else None))
    return failed


def _has_died(future: Future[Any]) -> bool:
    """Return True if a task's worker died.

    Raises
    ------
    InputError
        If the cluster itself is gone.
    """
    if future.cancelled():
        raise InputError("the cluster went away; the same command goes on where this one stopped")
    return isinstance(error := future.exception(), BrokenExecutor) or _is_given_up(error)


def _is_given_up(error: BaseException | None) -> bool:
    """Return True if dask gave a task up after several deaths; by name, for dask may not be installed."""
    return type(error).__name__ == "KilledWorker"


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Shield processes that the body starts from Ctrl-C: the parent is interrupted, and stops its workers."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def describe_machine(command: str = "") -> dict[str, Any]:
    """Describe the machine and the code: processor, cores, system, versions, commit, command."""
    packages = ("rectmerge", "numpy", "opencv-python-headless", "numba", "pybullet", "rosbags")
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        "packages": {name: found for name in packages if (found := _version(name))},
        "commit": _commit(),
        "command": command,
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8", errors="replace").splitlines() if info.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _commit() -> str | None:
    """Return the commit of a checkout, marked if files changed but the pages it makes; None if this is no checkout."""
    git = ["git", "-C", str(Path(__file__).parent)]
    try:
        call = functools.partial(subprocess.run, capture_output=True, text=True, check=True, timeout=10)
        head = call([*git, "rev-parse", "--short=12", "HEAD"]).stdout.strip()
        but_pages = ["--", ":/", ":(top,exclude)results"]
        changed = call([*git, "status", "--porcelain", "--untracked-files=no", *but_pages]).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{head}, changed" if changed else head
