"""Compilation of kernels: once per machine, cached next to the source or in the user's cache, else in memory."""

from __future__ import annotations

import importlib
import logging
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import config, event
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys

P = ParamSpec("P")
R = TypeVar("R")

log = logging.getLogger(__name__)
NUMBA: Any = config  # its attributes are set when it is imported


# A kernel is compiled anew for every constant that another passes it, and for every layout of an array. So kernels pass
# each other these, whose types of numpy are no constants to numba, and no slices.
ZERO = cast(int, np.int64(0))
NO, YES = cast(bool, np.bool_(False)), cast(bool, np.bool_(True))


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on its first call; keep the result on disk where a cache can be written."""
    dispatcher: Any = numba.njit(nogil=True)(function)
    with suppress(RuntimeError):  # a read-only file system offers no place for a cache
        dispatcher._cache = _KernelCache(function)  # type: ignore[no-untyped-call] # as `cache=True` does with numba's own
    return cast(Callable[P, R], dispatcher)


class _KernelCache(FunctionCache):
    """Cache that loads machine code without numba's registries of types: only compiling needs these, 0.2 s a start."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code for a signature; None where it is not in the cache."""
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call] # numba's own


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


class _LightOptimisation(event.Listener):
    """Listener that has LLVM optimise at level 1 while it compiles a kernel.

    Level 3, numba's own, takes a sixth longer to compile, and no stage of a merge runs faster by it.
    """

    depth = 0
    others: Any = None  # the level of everything else in the process

    def on_start(self, compilation: event.Event) -> None:
        module = compilation.data["dispatcher"].py_func.__module__
        if self.depth == 0 and not str(module).startswith(__package__):
            return
        if self.depth == 0:
            self.others = NUMBA.OPT
            NUMBA.OPT = type(NUMBA.OPT)(1)
        self.depth += 1

    def on_end(self, compilation: event.Event) -> None:
        if self.depth == 0:
            return
        self.depth -= 1
        if self.depth == 0:
            NUMBA.OPT = self.others


NOTICE = _Notice()
for listener in (NOTICE, _LightOptimisation()):
    event.register("numba:compile", listener)  # type: ignore[no-untyped-call] # numba's own, without annotations


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


def is_cached(dispatcher: Any) -> bool:
    """Return whether the cache on disk has a kernel of this source for some types."""
    index = dispatcher._cache._cache_file if cache_folder(dispatcher) else None
    return index is not None and bool(index._load_index())


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
