"""Processes and those that they started, however far these went from them."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Collection
from pathlib import Path

ADOPT_ORPHANS = 36  # prctl's PR_SET_CHILD_SUBREAPER
PASSES = 3  # through the tree, which may grow while it is ended


def adopt_orphans() -> None:
    """Become the parent of descendants whose own parent ends, also of those in another session."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(ADOPT_ORPHANS, 1)


def children_of(pid: int) -> list[int]:
    """Return the processes that a process started or adopted; none where the system does not say."""
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
        return [int(child) for task in tasks for child in (task / "children").read_text(encoding="ascii").split()]
    except OSError:  # it has ended, or this is not Linux
        return []


def end_descendants(pid: int, *, spared: Collection[int] = ()) -> None:
    """Kill all descendants of a process, except those children that are spared, with theirs."""
    for _ in range(PASSES):
        for child in children_of(pid):
            if child not in spared:
                end_descendants(child)
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(child, signal.SIGKILL)


def reap_children(*, spared: Collection[int] = ()) -> None:
    """Let killed children of this process go, except those that are spared."""
    for child in children_of(os.getpid()):
        if child not in spared:
            with contextlib.suppress(ChildProcessError):
                os.waitpid(child, 0)
