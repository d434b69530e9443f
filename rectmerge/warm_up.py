"""Compilation of every kernel in one go, by running what uses them on a small drawn building."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

import cv2
import numpy as np

from rectmerge import _kernels
from rectmerge._kernels.compiling import (
    after_each_compilation,
    cache_folder,
    is_compiled,
    is_uncached,
    kernels_of,
)
from rectmerge._kernels.spline_lattice import gradients
from rectmerge.aligning import align, check
from rectmerge.alignment import Certifies
from rectmerge.analysis.quality import measure_quality
from rectmerge.elastic.unbend import unbend
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.methods import DEFAULT_METHOD, make_method
from rectmerge.rectangles import largest_rectangle
from rectmerge.similarity import Similarity

COMPILED_METHODS = ("paper", "stochastic-search")  # besides the default method; the others run no kernels of their own
KERNELS_OF_OTHERS = (  # than the merging of maps by the default method
    *("bounding.", "neighbours.", "orientation.", "random_walk.", "rmap.", "triangles."),
    *("rectangles.largest", "runs.interval_end", "runs.best_in_interval"),
)
CERTIFIED_SCALE = (0.9, 1.1)
SHIFT_CELLS = 2.2  # by which walls lie apart enough to be bent together
CERTIFY_SECONDS = 1.0  # enough for one step of the search


class WarmUp(NamedTuple):
    """Result of a warm-up.

    Parameters
    ----------
    compiled
        Number of functions that were compiled; 0 where all came from the cache.
    cpu_s
        Processor time, seconds.
    cache
        Folder of the compiled code; None where it cannot be kept.
    """

    compiled: int
    cpu_s: float
    cache: Path | None


def warm_up(progress: Callable[[int, int], None] | None = None, *, only_merging: bool = False) -> WarmUp:
    """Compile all kernels, or load them from the cache of this machine.

    Parameters
    ----------
    progress
        Called with the number of kernels that are ready, and of all, whenever one more has been compiled.
    only_merging
        Leave out the kernels that merging by the default method does not use.

    Examples
    --------
    ``warm_up(lambda ready, of: print(f"{ready} of {of}"))``
    """
    kernels = [kernel for kernel in kernels_of(_kernels) if not only_merging or _is_of_merging(kernel)]
    if not kernels:  # NUMBA_DISABLE_JIT is set
        return WarmUp(0, 0.0, None)
    started, compiled, shown = time.process_time(), 0, 0

    def count() -> None:
        nonlocal compiled, shown
        compiled += 1
        ready = sum(map(is_compiled, kernels))
        if progress is not None and ready > shown:
            progress(ready, len(kernels))
            shown = ready

    with after_each_compilation(count):
        _merge_small_building()
        if not only_merging:
            _use_other_kernels()
    return WarmUp(compiled, time.process_time() - started, cache_folder(kernels[0]))


def is_first_merge() -> bool:
    """Return whether the kernels of merging can be kept on this machine and are not yet; reads a file of 2 KB."""
    return is_uncached(gradients)  # the last of them that a warm-up compiles


def small_building() -> tuple[OccupancyGrid, OccupancyGrid]:
    """Draw a building of six rooms, and its copy turned by 30 degrees."""
    cells = np.full((96, 128), FREE, np.int8)
    cells[[0, 40, -1], :] = cells[:, [0, 50, 90, -1]] = OCCUPIED
    cells[60:70, 50] = cells[20:30, 90] = cells[40, 15:25] = FREE  # doors
    turn = cv2.getRotationMatrix2D((63.5, 47.5), 30, 1.0) + np.array([[0, 0, 20], [0, 0, 36]])
    turned = cv2.warpAffine(cells.view(np.uint8), turn, (168, 168), flags=cv2.INTER_NEAREST, borderValue=255)
    return OccupancyGrid(cells), OccupancyGrid(turned.view(np.int8))


def _is_of_merging(kernel: Any) -> bool:
    module = kernel.py_func.__module__.removeprefix(f"{_kernels.__name__}.")
    return not f"{module}.{kernel.py_func.__name__}".startswith(KERNELS_OF_OTHERS)


def _merge_small_building() -> None:
    a, b = small_building()
    align(a, b)
    measure_quality(a)
    unbend(a, a, Similarity(tx=SHIFT_CELLS, ty=SHIFT_CELLS))


def _use_other_kernels() -> None:
    a, b = small_building()
    pixels = align(a, b).candidates[0].pixels
    check(a, b, pixels)
    cast(Certifies, make_method(DEFAULT_METHOD)).certify(a, b, pixels, scale=CERTIFIED_SCALE, seconds=CERTIFY_SECONDS)
    for name in COMPILED_METHODS:
        align(a, b, method=name)
    largest_rectangle(a.free)
