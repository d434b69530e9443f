"""How kernels are compiled: once per machine, cached beside the source or in the user's cache, else in memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on its first call; keep the result on disk where a cache can be written."""
    try:
        return cast(Callable[P, R], numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:  # a read-only file system offers no place for a cache
        return cast(Callable[P, R], numba.njit(nogil=True)(function))
