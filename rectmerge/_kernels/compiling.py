"""Compilation of kernels: once per machine, cached next to the source or in the user's cache, else in memory."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba
from numba.core import event

P = ParamSpec("P")
R = TypeVar("R")

log = logging.getLogger(__name__)


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on its first call; keep the result on disk where a cache can be written."""
    try:
        return cast(Callable[P, R], numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:  # a read-only file system offers no place for a cache
        return cast(Callable[P, R], numba.njit(nogil=True)(function))


class _Notice(event.Listener):
    """Listener that logs a line before the process's first compilation; reading from a cache triggers no event."""

    is_logged = False

    def on_start(self, compilation: event.Event) -> None:
        if self.is_logged:
            return
        self.is_logged = True
        is_cached = compilation.data["dispatcher"].stats.cache_path is not None
        frequency = (
            "once on this machine for each part of the program"
            if is_cached
            else "at every start: no cache can be written, NUMBA_CACHE_DIR may name a place"
        )
        log.info("compiling the inner loops, which takes up to a minute (%s) ...", frequency)

    def on_end(self, compilation: event.Event) -> None:
        """Do nothing: the line comes before the wait, not after it."""


NOTICE = _Notice()
event.register("numba:compile", NOTICE)  # type: ignore[no-untyped-call] # numba's own, without annotations
