"""Compilation of kernels: once per machine, cached next to the source or in the user's cache, else in memory."""

from __future__ import annotations

import importlib
import logging
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.core.dispatcher import Dispatcher

P = ParamSpec("P")
R = TypeVar("R")

log = logging.getLogger(__name__)


# A kernel is compiled anew for every constant that another passes it, and for every layout of an array. So kernels pass
# each other these, whose types of numpy are no constants to numba, and no slices.
ZERO = cast(int, np.int64(0))
NO, YES = cast(bool, np.bool_(False)), cast(bool, np.bool_(True))


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
            "once on this machine for each command"
            if is_cached
            else "at every start: no cache can be written, NUMBA_CACHE_DIR may name a place"
        )
        log.info("compiling inner loops (%s; rectmerge warm-up compiles them all in one go) ...", frequency)

    def on_end(self, compilation: event.Event) -> None:
        """Do nothing: the line comes before the wait, not after it."""


NOTICE = _Notice()
event.register("numba:compile", NOTICE)  # type: ignore[no-untyped-call] # numba's own, without annotations


def kernels_of(package: ModuleType) -> list[Any]:
    """Return the kernels that a package's modules define, as numba's dispatchers."""
    modules = [
        importlib.import_module(f"{package.__name__}.{found.name}") for found in pkgutil.iter_modules(package.__path__)
    ]
    return [
        member
        for module in modules
        for member in vars(module).values()
        if isinstance(member, Dispatcher) and member.py_func.__module__ == module.__name__
    ]


def is_compiled(dispatcher: Any) -> bool:
    """Return whether a kernel has been compiled, or loaded from a cache, for some types."""
    return bool(dispatcher.signatures)


def cache_folder(dispatcher: Any) -> Path | None:
    """Return the folder of a kernel's cache; None where none can be written."""
    path = dispatcher.stats.cache_path
    return None if path is None else Path(path)


@contextmanager
def after_each_compilation(call: Callable[[], None]) -> Iterator[None]:
    """Make a call after each function that is compiled meanwhile."""
    with event.install_listener("numba:compile", _Caller(call)):
        yield


class _Caller(event.Listener):
    def __init__(self, call: Callable[[], None]) -> None:
        self._call = call

    def on_start(self, compilation: event.Event) -> None:
        """Do nothing: nothing is compiled yet."""

    def on_end(self, compilation: event.Event) -> None:
        self._call()
