"""Limits of time and memory: calls in a child process, which is killed if it exceeds them."""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import functools
import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Literal, TypeVar

from rectmerge.errors import InputError
from scenarios.execution.attempt import Attempt, attempt, memory_mb
from scenarios.execution.processes import adopt_orphans, end_descendants

T = TypeVar("T")
TIMEOUT_S = 300.0  # of one answer
POLL_S = 0.02  # between looks at a child's memory
WARM_UP_TIMES = 10  # the time limit: compiling takes longer than answering
DEATHS = 3  # of processes at one task, until the task is held to be the cause
SET_DEATH_SIGNAL = 1  # prctl's PR_SET_PDEATHSIG
# dask sets it for its workers: every array is then given back to the system at once, and asked for anew, page by page
COSTLY_SETTINGS = ("MALLOC_TRIM_THRESHOLD_",)
Does = Literal["answers", "makes pairs"]  # a child per kind, so that memory is measured apart


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits of one call: an answer, or the making of a mission's pairs.

    Parameters
    ----------
    timeout_s
        Wall time.
    memory_mb
        Resident memory of the process that makes the call and of those it starts; None is no limit.
    """

    timeout_s: float = TIMEOUT_S
    memory_mb: float | None = None

    def __post_init__(self) -> None:
        if not self.timeout_s > 0 or (self.memory_mb is not None and not self.memory_mb > 0):
            raise InputError(f"limits must be > 0, got {self.timeout_s} s and {self.memory_mb} MB")


MAKING = Limits(timeout_s=3600.0)  # a mission and its pairs: the largest buildings take minutes


def call_within(
    limits: Limits, call: Callable[[], T], *, warm_up: Callable[[], object] | None = None, does: Does = "answers"
) -> Attempt[T]:
    """Make a call in a child process of this thread, which is replaced after it was killed.

    Parameters
    ----------
    limits
        What the call may take; the child is killed at once where it takes more.
    call
        The work, picklable, its result too. A process that dies at it three times makes it fail.
    warm_up
        Done once per child before the clock starts, such as to compile; picklable and comparable. What cannot be
        done within ten times the time limit is left out for good.
    does
        What the call is: calls of one kind share a child.

    Examples
    --------
    >>> call_within(Limits(timeout_s=60), dict).value
    {}
    """
    packed = attempt(lambda: (pickle.dumps(call), warm_up and pickle.dumps(warm_up)))
    if packed.value is None:
        return Attempt(failure=packed.failure, reason=packed.reason, log=packed.log)
    work, first = packed.value
    died: Attempt[T] = Attempt()
    for _ in range(DEATHS):
        try:
            if first is not None:
                _own_child(does).warm(first, limits)
            got: Attempt[T] = _own_child(does).call(work, limits)
            return got
        except _ChildDiedError as death:
            died = death.as_attempt()
    return died


def die_with(parent: int) -> None:
    """Have this process killed when the process that started it ends, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before it could be watched
        os._exit(1)


def serve(handle: int, parent: int) -> None:
    """Make calls until the other end of the pipe is closed; the loop of a child process."""
    die_with(parent)
    adopt_orphans()
    import cv2

    cv2.setNumThreads(1)  # one core per answer, so that times mean the same with any number of workers
    with Connection(handle) as pipe:
        pipe.send_bytes(b"ready")
        while True:
            try:
                work = pipe.recv_bytes()
            except EOFError:
                return
            answer = attempt(functools.partial(_answer, work))
            pipe.send_bytes(answer.value or pickle.dumps(answer))


def _answer(work: bytes) -> bytes:
    return pickle.dumps(attempt(pickle.loads(work)))


class _ChildDiedError(Exception):
    """A child ended in the middle of a call, by itself or killed by somebody else."""

    def __init__(self, status: int, does: Does) -> None:
        super().__init__(f"the process that {does} {describe_exit(status)}")
        self.out_of_memory = status == -signal.SIGKILL

    def as_attempt(self) -> Attempt[Any]:
        return Attempt(failure="out-of-memory" if self.out_of_memory else "error", reason=f"{self}, {DEATHS} times")


def describe_exit(status: int | None) -> str:
    """Describe an exit status, negative for a signal."""
    if status == -signal.SIGKILL:
        return "was killed, most likely for want of memory"
    if status is not None and status < 0:
        return f"died by signal {signal.Signals(-status).name}"
    return f"died with status {status}"


class _Child:
    """A process that makes calls, and the pipe to it."""

    def __init__(self, does: Does) -> None:
        self._does: Does = does
        self._folder = tempfile.mkdtemp(prefix="rectbench-")  # this process's own: a killed child removes nothing
        ours, theirs = socket.socketpair()
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            f"from scenarios.execution.limits import serve; serve({theirs.fileno()}, {os.getpid()})"
        )
        # a session of its own: Ctrl-C in the terminal is for the parent, and what it starts is killed with it
        self._process = subprocess.Popen(
            [sys.executable, "-c", code],
            pass_fds=[theirs.fileno()],
            env={name: value for name, value in os.environ.items() if name not in COSTLY_SETTINGS}
            | {"TMPDIR": self._folder},
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=2,  # what a method prints must not get into the summary
        )
        theirs.close()
        self._pipe = Connection(ours.detach())
        self._warmed: set[bytes] = set()
        try:
            self._pipe.recv_bytes()  # it has started: from now on its time is its own
        except (EOFError, OSError):
            raise _ChildDiedError(self._process.wait(), self._does) from None

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def warm(self, work: bytes, limits: Limits) -> None:
        if work in self._warmed or work in _never_warm:
            return
        self._warmed.add(work)
        _never_warm.add(work)  # unless the child lives through it
        self.call(work, Limits(timeout_s=WARM_UP_TIMES * limits.timeout_s, memory_mb=limits.memory_mb))
        if self.is_alive:
            _never_warm.discard(work)

    def call(self, work: bytes, limits: Limits) -> Attempt[Any]:
        try:
            self._pipe.send_bytes(work)
            if broken := self._overrun(limits):
                return broken
            got: Attempt[Any] = pickle.loads(self._pipe.recv_bytes())
            return got
        except (EOFError, OSError):
            raise _ChildDiedError(self._process.wait(), self._does) from None
        except BaseException:  # interrupted: what it still answers would be taken for the next answer
            self.stop()
            raise

    def _overrun(self, limits: Limits) -> Attempt[Any] | None:
        """Wait for an answer; kill the child if it exceeds its limits, and return the failure."""
        ends = time.monotonic() + limits.timeout_s
        while (left := ends - time.monotonic()) > 0:
            if self._pipe.poll(min(left, POLL_S if limits.memory_mb else threading.TIMEOUT_MAX)):
                return None
            if limits.memory_mb and memory_mb(self._process.pid) > limits.memory_mb:
                self.stop()
                return Attempt(failure="out-of-memory", reason=f"took more than {limits.memory_mb:g} MB")
        self.stop()
        what = "no answer" if self._does == "answers" else "no pairs"
        return Attempt(failure="timeout", reason=f"{what} within {limits.timeout_s:g} s")

    def stop(self) -> None:
        end_descendants(self._process.pid)  # some may have left its session
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._pipe.close()
        shutil.rmtree(self._folder, ignore_errors=True)


_own = threading.local()
_started: set[_Child] = set()
_never_warm: set[bytes] = set()


def _own_child(does: Does) -> _Child:
    """Return this thread's child for a kind of calls, a new one if none is alive."""
    children: dict[Does, _Child] = _own.__dict__.setdefault("children", {})
    child = children.get(does)
    if child is None or not child.is_alive:
        if child is not None:
            _started.discard(child)
            child.stop()
        child = children[does] = _Child(does)
        _started.add(child)
    return child


@atexit.register
def stop_children() -> None:
    """Stop every child of this process."""
    while _started:
        _started.pop().stop()
