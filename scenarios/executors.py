"""Where work is done: in this process or in workers whose death is noticed, with limits, failures and the machine."""

from __future__ import annotations

import functools
import math
import multiprocessing
import os
import platform
import signal
import subprocess
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar

import cv2

from rectmerge.errors import RectMergeError
from scenarios.score import Outcome

P = ParamSpec("P")
T = TypeVar("T")
Item = TypeVar("Item")
OPENCV_NO_MEMORY = -4  # cv::Error::StsNoMem, which OpenCV raises in place of MemoryError
RECYCLE_AFTER = 64  # tasks: a worker that loads many worlds grows


class OutOfTimeError(RectMergeError):
    """A call took longer than its time limit."""


class WorkerDiedError(RectMergeError):
    """A worker process ended in the middle of a task; `out_of_memory` where the system killed it."""

    def __init__(self, exit_code: int | None) -> None:
        self.out_of_memory = exit_code == -signal.SIGKILL
        why = "was killed, most likely for want of memory" if self.out_of_memory else f"died with status {exit_code}"
        super().__init__(f"the worker process {why}")


class Workers(Executor):
    """Worker processes, one task each at a time: one that dies takes only its own task with it and is replaced.

    A task that raises ends its worker, and a task whose worker died raises `WorkerDiedError`; the standard pool would
    fail every task in flight and not say which one it was.

    Parameters
    ----------
    count
        How many processes, > 0.
    """

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count, thread_name_prefix="worker")
        self._own = threading.local()
        self._started: list[_Worker] = []

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Queue a task; function and arguments must be picklable."""
        return self._threads.submit(self._call, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop the workers; without `wait`, in the middle of what they do."""
        if not wait:
            for worker in self._started:
                worker.stop()
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures or not wait)
        for worker in self._started:
            worker.stop()

    def _call(self, fn: Callable[..., T], args: tuple[Any, ...], kwargs: dict[str, Any]) -> T:
        worker: _Worker | None = getattr(self._own, "worker", None)
        if worker is None or worker.tasks_done >= RECYCLE_AFTER or not worker.is_alive:
            if worker is not None:
                worker.stop()
                self._started.remove(worker)
            worker = self._own.worker = _Worker()
            self._started.append(worker)
        result: T = worker.call(fn, args, kwargs)
        return result


@contextmanager
def local_workers(count: int) -> Iterator[Executor | None]:
    """Open worker processes, None for one; where the body fails they stop in the middle of what they do."""
    executor = Workers(count) if count > 1 else None
    done = False
    try:
        yield executor
        done = True
    finally:
        if executor:
            executor.shutdown(wait=done)


class _Worker:
    """One process and the pipe to it."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")  # a fork would copy locks and the physics engine's state
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self.tasks_done = 0

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def call(self, fn: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        self.tasks_done += 1
        try:
            self._pipe.send((fn, args, kwargs))
            return self._pipe.recv()
        except (EOFError, OSError):
            self._process.join()
            raise WorkerDiedError(self._process.exitcode) from None

    def stop(self) -> None:
        self._process.terminate()
        self._process.join()
        self._pipe.close()


def _serve(pipe: Connection) -> None:
    """Do tasks until the other end goes away."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted, and stops its workers
    while True:
        try:
            fn, args, kwargs = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(fn(*args, **kwargs))


def completed(
    executor: Executor | None, fn: Callable[[Item], T], items: Sequence[Item]
) -> Iterator[tuple[Item, Future[T]]]:
    """Do `fn` on every item and yield each item with its finished future, as they end.

    Parameters
    ----------
    executor
        Where the work is done; None is this process, one item after the other.
    fn
        The work; picklable where the executor needs it.
    items
        What to do it on.
    """
    if executor is None:
        for item in items:
            done: Future[T] = Future()
            done.set_result(fn(item))
            yield item, done
        return
    futures = {executor.submit(fn, item): item for item in items}
    for future in as_completed(futures):
        yield futures[future], future


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise `OutOfTimeError` in the body after `seconds` of wall time, where signals can do it.

    Works in the main thread of a process on systems with alarms, elsewhere it does nothing. The interpreter must get
    a word in: a single compiled call is only interrupted when it returns.
    """
    if (
        not math.isfinite(seconds)
        or threading.current_thread() is not threading.main_thread()
        or not hasattr(signal, "setitimer")
    ):
        yield
        return

    def expire(_signal: int, _frame: object) -> None:
        raise OutOfTimeError(f"no answer within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt(Generic[T]):
    """What came of a call: its value, or the outcome, the reason and the traceback of its failure."""

    value: T | None = None
    failure: Outcome | None = None
    reason: str = ""
    log: str | None = None


def attempt(call: Callable[[], T], timeout_s: float = math.inf) -> Attempt[T]:
    """Make a call that may fail in any way, and go on.

    Parameters
    ----------
    call
        Somebody's method, or the making of a pair.
    timeout_s
        Wall time after which it counts as failed; see `time_limit` for what that can stop.
    """
    try:
        with time_limit(timeout_s):
            return Attempt(value=call())
    except OutOfTimeError as error:
        return Attempt(failure="timeout", reason=str(error))
    except MemoryError:
        return Attempt(failure="out-of-memory", reason="memory ran out", log=traceback.format_exc())
    except Exception as error:  # noqa: BLE001 - the one place where a crash becomes a row and the suite goes on
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        starved = isinstance(error, cv2.error) and error.code == OPENCV_NO_MEMORY
        return Attempt(failure="out-of-memory" if starved else "error", reason=reason, log=traceback.format_exc())


def reset_peak_memory() -> bool:
    """Start measuring this process's peak memory anew; False where the system cannot."""
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:
        return False
    return True


def peak_memory_mb() -> float | None:
    """Return the highest resident memory of this process since the reset, in MB; None where it cannot be told."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    peaks = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(peaks[0]) / 1024 if peaks else None


def describe_machine(command: str = "") -> dict[str, Any]:
    """Describe what figures of speed depend on: processor, cores, system, versions, the code's commit, the command."""
    packages = ("rectmerge", "numpy", "opencv-python-headless", "numba", "pybullet")
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
    """Return the commit of a checkout, marked where it was changed; None where this is no checkout."""
    git = ["git", "-C", str(Path(__file__).parent)]
    try:
        call = functools.partial(subprocess.run, capture_output=True, text=True, check=True, timeout=10)
        head = call([*git, "rev-parse", "--short=12", "HEAD"]).stdout.strip()
        changed = call([*git, "status", "--porcelain", "--untracked-files=no"]).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{head}, changed" if changed else head
