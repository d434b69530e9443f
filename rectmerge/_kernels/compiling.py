"""Compilation of kernels: once per machine, cached next to the source or in the user's cache, else in memory."""

from __future__ import annotations

import hashlib
import importlib
import logging
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import config, event
from numba.extending import is_jitted

try:
    from numba.core.caching import FunctionCache
    from numba.core.runtime.nrt import rtsys
except ImportError:  # numba promises neither; without them `kernel` takes numba's cache
    FunctionCache, rtsys = object, None  # type: ignore[misc, assignment]

P = ParamSpec("P")
R = TypeVar("R")

log = logging.getLogger(__name__)
NUMBA: Any = config  # its attributes are set when it is imported
KERNEL_OPT = 1  # level of LLVM's optimisation, see `_LightOptimisation`


# A kernel is compiled anew for every constant that another passes it, and for every layout of an array. So kernels pass
# each other these, whose types of numpy are no constants to numba, and no slices.
ZERO = cast(int, np.int64(0))
NO, YES = cast(bool, np.bool_(False)), cast(bool, np.bool_(True))


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on its first call; keep the result on disk where a cache can be written."""
    dispatcher: Any = numba.njit(nogil=True)(function)
    if is_jitted(dispatcher):  # else NUMBA_DISABLE_JIT is set
        with suppress(RuntimeError):  # a read-only file system offers no place for a cache
            if (own := _own_cache(function)) is not None and hasattr(dispatcher, "_cache"):
                dispatcher._cache = own
            else:
                dispatcher = numba.njit(nogil=True, cache=True)(function)
    return cast(Callable[P, R], dispatcher)


def _own_cache(function: Any) -> Any:
    """Return our cache of a kernel; None where this numba has not the names that it uses."""
    try:
        return _KernelCache(function)
    except (AttributeError, TypeError):
        return None


class _KernelCache(FunctionCache):
    """Cache that knows all kernels of a package, and loads machine code without numba's registries of types.

    Numba's own takes code as fresh while the file of the function is the same, though it holds what was compiled from
    other files too. Its registries are needed by compiling alone, and take 0.2 s a start.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call] # numba's own
        index, folder = self._cache_file, Path(function.__code__.co_filename).parent
        level = KERNEL_OPT if _is_ours(function) else int(NUMBA.OPT)
        index._source_stamp = (index._source_stamp, source_hash(folder), source_hash(Path(__file__).parent), level)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code for a signature; None where it is not in the cache."""
        try:
            rtsys.initialize(target_context)
            guard, load = self._guard_against_spurious_io_errors(), self._load_overload
        except AttributeError:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call] # numba's own
        with guard:
            return load(sig, target_context)  # type: ignore[no-untyped-call] # numba's own


@cache
def source_hash(folder: Path) -> str:
    """Return the hash of all sources in the folder of a package, as they were when a process first asked."""
    digest = hashlib.sha256()
    for file in sorted(folder.glob("*.py")):
        content = file.read_bytes()
        digest.update(f"{file.name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _is_ours(function: Any) -> bool:
    return str(function.__module__).startswith(__package__)


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
    """Listener that has LLVM optimise at level 1 while it compiles a kernel of this package, and what that calls.

    Level 3, numba's own, takes a sixth longer to compile, and no stage of a merge runs faster by it. It stays that of
    all else in the process, the kernels of other packages among them.
    """

    depth = 0
    others: Any = None  # the level of everything else in the process

    def on_start(self, compilation: event.Event) -> None:
        if self.depth == 0 and not _is_ours(compilation.data["dispatcher"].py_func):
            return
        if self.depth == 0:
            self.others = NUMBA.OPT
            NUMBA.OPT = type(NUMBA.OPT)(KERNEL_OPT)
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
    """Return the kernels that a package's modules define, as numba's dispatchers; none with NUMBA_DISABLE_JIT."""
    modules = [
        importlib.import_module(f"{package.__name__}.{found.name}") for found in pkgutil.iter_modules(package.__path__)
    ]
    return [
        member
        for module in modules
        for member in vars(module).values()
        if is_jitted(member) and member.py_func.__module__ == module.__name__
    ]


def is_compiled(dispatcher: Any) -> bool:
    """Return whether a kernel has been compiled, or loaded from a cache, for some types."""
    return bool(dispatcher.signatures)


def is_uncached(kernel: Any) -> bool:
    """Return whether a kernel is still to be compiled for the cache on disk, which has none of these sources.

    False where nothing is compiled, no cache can be written, or this numba does not say.
    """
    is_kept = is_jitted(kernel) and cache_folder(kernel) is not None
    try:
        return is_kept and not cast(Any, kernel)._cache._cache_file._load_index()
    except AttributeError:
        return False


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
