"""Calls that may fail in any way, with their failures as values, and the memory of processes."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import cv2

from scenarios.scoring.score import Outcome

T = TypeVar("T")
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 2**20
OPENCV_NO_MEMORY = -4  # cv::Error::StsNoMem, which OpenCV raises in place of MemoryError


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt(Generic[T]):
    """Result of a call: its value, or the outcome, the reason and the traceback of its failure."""

    value: T | None = None
    failure: Outcome | None = None
    reason: str = ""
    log: str | None = None


def attempt(call: Callable[[], T]) -> Attempt[T]:
    """Make a call that may fail in any way, and go on."""
    try:
        return Attempt(value=call())
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
    """Return the highest resident memory of this process since the reset, in MB; None if the system does not say."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    peaks = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(peaks[0]) / 1024 if peaks else None


def memory_mb(pid: int) -> float:
    """Return the resident memory of a process and of those it started, in MB; 0 if the process has ended."""
    process = Path(f"/proc/{pid}")
    try:
        pages = int((process / "statm").read_text(encoding="ascii").split()[1])
        tasks = list((process / "task").iterdir())
        children = [int(child) for task in tasks for child in (task / "children").read_text(encoding="ascii").split()]
    except (OSError, IndexError):  # it has ended meanwhile
        return 0.0
    return pages * PAGE_MB + sum(memory_mb(child) for child in children)
