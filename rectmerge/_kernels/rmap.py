"""R-map: the greedy sequence of survey, carve and repeat, exact and lazy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import ZERO, kernel
from rectmerge._kernels.runs import best_in_interval, interval_end

SMALL_AREA = 7  # below this area, sweeping the few cells that are left beats the heap


@kernel
def move(heap: NDArray[np.int64], source: int, target: int) -> None:
    """Copy a row of the heap, element by element: a slice would cost ten times as much."""
    heap[target, 0] = heap[source, 0]
    heap[target, 1] = heap[source, 1]
    heap[target, 2] = heap[source, 2]


@kernel
def push(heap: NDArray[np.int64], size: int, key: int, rows: int, entry: int) -> None:
    """Sift an entry into a binary heap that holds `size`, smallest key first."""
    i = size
    while i > 0:
        parent = (i - 1) >> 1
        if heap[parent, 0] <= key:
            break
        move(heap, parent, i)
        i = parent
    heap[i, 0], heap[i, 1], heap[i, 2] = key, rows, entry


@kernel
def drop_first(heap: NDArray[np.int64], size: int) -> None:
    """Remove the first entry of a heap that holds `size`."""
    last = size - 1
    key = heap[last, 0]
    i, child = ZERO, 1
    while child < last:
        if child + 1 < last and heap[child + 1, 0] < heap[child, 0]:
            child += 1
        if heap[child, 0] >= key:
            break
        move(heap, child, i)
        i = child
        child = 2 * i + 1
    move(heap, last, i)


@kernel
def is_free(runs: NDArray[np.uint16], x: int, top: int, bottom: int, width: int) -> bool:
    """Check if the rectangle is still free."""
    column = runs[x]
    for y in range(top, bottom):  # noqa: SIM110 - compiled loop
        if column[y] < width:
            return False
    return True


@kernel
def carve(
    runs: NDArray[np.uint16], labels: NDArray[np.int32], x: int, top: int, bottom: int, width: int, label: int
) -> None:
    """Take the rectangle out of the free space, shorten the runs to its left, and label its cells."""
    for column in range(x, x + width):
        for y in range(top, bottom):
            runs[column, y] = 0
    for column in range(x - 1, -1, -1):
        reach = x - column
        here = runs[column]
        changed = 0
        for y in range(top, bottom):
            changed |= here[y] > reach
            here[y] = min(here[y], reach)
        if not changed:
            break
    for y in range(top, bottom):
        for column in range(x, x + width):
            labels[y, column] = label


@kernel
def grow_if_full(heap: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Return the heap, twice as long where it is full."""
    if size < len(heap):
        return heap
    longer = np.empty((2 * size, 3), np.int64)
    longer[:size] = heap
    return longer


@kernel
def survey(
    runs: NDArray[np.uint16],
    newest: NDArray[np.int32],
    x: int,
    rows: tuple[int, int],
    entry: int,
    least_area: int,
    counts: NDArray[np.int64],
    heap: NDArray[np.int64],
    stack: NDArray[np.int32],
) -> NDArray[np.int64]:
    """Enter the best rectangle of every free interval of column x in `rows` that no entry after `entry` covers."""
    y, end = rows
    while y < end:
        if runs[x, y] == 0:
            y += 1
            continue
        stop, longest, may_begin_here = interval_end(runs, x, y, end)
        if newest[x, y] <= entry:
            newest[x, y] = counts[1]
            if may_begin_here and longest * (stop - y) >= least_area:
                area, top, bottom = best_in_interval(runs, x, y, stop, least_area, stack)
                if area > 0:
                    heap = grow_if_full(heap, counts[0])
                    key, interval = (-area << 32) + (x << 16) + bottom, (y << 32) + (stop << 16) + top
                    push(heap, counts[0], key, interval, counts[1])
                    counts[0] += 1
                    counts[1] += 1
        y = stop
    return heap


@kernel
def survey_right_of(
    runs: NDArray[np.uint16],
    newest: NDArray[np.int32],
    x: int,
    rows: tuple[int, int],
    least_area: int,
    counts: NDArray[np.int64],
    heap: NDArray[np.int64],
    stack: NDArray[np.int32],
) -> NDArray[np.int64]:
    """Survey again the free intervals of column x that touch `rows`, after their left neighbours were carved."""
    if x == len(runs):
        return heap
    begin, end = rows
    while begin > 0 and runs[x, begin] > 0 and runs[x, begin - 1] > 0:
        begin -= 1
    while end < runs.shape[1] and runs[x, end - 1] > 0 and runs[x, end] > 0:
        end += 1
    return survey(runs, newest, x, (begin, end), counts[1], least_area, counts, heap, stack)


@kernel
def append(boxes: NDArray[np.int32], count: int, x: int, y: int, w: int, h: int) -> NDArray[np.int32]:
    """Append a rectangle, into a longer array where it is full."""
    if count == len(boxes):
        longer = np.empty((2 * count + 64, 4), np.int32)
        longer[:count] = boxes
        boxes = longer
    boxes[count, 0], boxes[count, 1], boxes[count, 2], boxes[count, 3] = x, y, w, h
    return boxes


@kernel
def carve_large(runs: NDArray[np.uint16], labels: NDArray[np.int32], least_area: int, most: int) -> NDArray[np.int32]:
    """Carve the largest rectangle until none of `least_area` is left or `most` are taken; return (N, 4) as x, y, w, h.

    A heap holds, for every maximal run of free cells of a column, its best rectangle when it was last surveyed. Areas
    only fall as space is carved, so an entry bounds what is left in its run: it is surveyed again only when it comes
    first and is no longer free. Only rectangles that nothing extends to the left are entered, hence carving has to
    survey the column right of the carved rectangle, where such rectangles may begin.
    """
    width, height = runs.shape
    boxes, count = np.empty((256, 4), np.int32), ZERO
    stack = np.empty((height + 1, 2), np.int32)
    newest = np.zeros((width, height), np.int32)  # the latest entry whose interval begins at a cell
    heap = np.empty((1024, 3), np.int64)  # area, x and bottom; begin, end and top; the entry's number
    counts = np.array([0, 1])  # entries in the heap, entries ever made
    for x in range(width):
        heap = survey(runs, newest, x, (ZERO, height), ZERO, least_area, counts, heap, stack)
    while counts[0] > 0 and count < most:  # Alg. 2, line 3
        key, rows, entry = heap[0, 0], heap[0, 1], heap[0, 2]
        area, x, bottom = -(key >> 32), (key >> 16) & 0xFFFF, key & 0xFFFF
        begin, end, top = rows >> 32, (rows >> 16) & 0xFFFF, rows & 0xFFFF
        drop_first(heap, counts[0])
        counts[0] -= 1
        w = area // (bottom - top)
        if is_free(runs, x, top, bottom, w):  # Alg. 2, line 4
            boxes = append(boxes, count, x, top, w, bottom - top)
            count += 1
            carve(runs, labels, x, top, bottom, w, count)  # Alg. 2, line 5
            heap = survey_right_of(runs, newest, x + w, (top, bottom), least_area, counts, heap, stack)
        heap = survey(runs, newest, x, (begin, end), entry, least_area, counts, heap, stack)
    return boxes[:count]


@kernel
def carve_small(
    runs: NDArray[np.uint16],
    labels: NDArray[np.int32],
    largest: int,
    least_area: int,
    most: int,
    boxes: NDArray[np.int32],
) -> NDArray[np.int32]:
    """Carve the rectangles of area `largest` and less: nothing greater is left, so each area is one sweep."""
    width, height = runs.shape
    count = len(boxes)
    cells = np.empty(width * height, np.uint32)  # x and y, in the order of ties
    left = 0
    for x in range(width):
        for y in range(height):
            if runs[x, y] > 0:
                cells[left] = (x << 16) + y
                left += 1
    for area in range(largest, least_area - 1, -1):
        kept = 0
        for i in range(left):
            x, y = np.int64(cells[i] >> 16), np.int64(cells[i] & 0xFFFF)  # type: ignore[assignment] # not int: unsigned to numba
            for h in range(area, 0, -1):
                if runs[x, y] * h < area or area % h > 0 or h > y + 1:
                    continue
                if count < most and is_free(runs, x, y + 1 - h, y + 1, area // h):
                    boxes = append(boxes, count, x, y + 1 - h, area // h, h)
                    count += 1
                    carve(runs, labels, x, y + 1 - h, y + 1, area // h, count)
            if runs[x, y] > 0:
                cells[kept] = cells[i]
                kept += 1
        left = kept
    return boxes[:count]


@kernel
def greedy_rectangles(
    runs: NDArray[np.uint16], labels: NDArray[np.int32], least_area: int, most: int
) -> NDArray[np.int32]:
    """Carve the largest rectangle until none of `least_area` is left or `most` are taken; return (N, 4) as x, y, w, h.

    `runs` is used up; `labels` (H, W) receives the number of the rectangle, from 1.
    """
    boxes = carve_large(runs, labels, max(least_area, SMALL_AREA), most)
    if least_area < SMALL_AREA and len(boxes) < most:
        boxes = carve_small(runs, labels, SMALL_AREA - 1, least_area, most, boxes)
    return boxes
