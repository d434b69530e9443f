"""The full R-map against one distance transform of the same map, and against the literal loop."""

from __future__ import annotations

import time

import cv2
import numpy as np
import pytest

from rectmerge.paper.rmap import rmap
from tests.rectmerge.paper import naive, plans

SIZES = ((317, 361), (393, 393), (1000, 1000))


def drawn(shape: tuple[int, int], *, is_noisy: bool) -> np.ndarray:
    """Draw a plan of this size; the noisy one is turned by 27 degrees on the same canvas and damaged."""
    if not is_noisy:
        return plans.floor_plan(*shape).free
    turned, _ = plans.moved(plans.floor_plan(*shape), 27)
    return plans.damaged(plans.on_canvas(turned, *shape), np.random.default_rng(0)).free


def transform_seconds(free: np.ndarray) -> float:
    """Time the yardstick: the minimum of 20 distance transforms on one thread."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    seconds = []
    for _ in range(20):
        started = time.perf_counter()
        cv2.distanceTransform(free.view(np.uint8), cv2.DIST_L2, 3)
        seconds.append(time.perf_counter() - started)
    cv2.setNumThreads(threads)
    return min(seconds)


@pytest.mark.parametrize("is_noisy", [False, True], ids=["clean", "noisy-and-rotated"])
@pytest.mark.parametrize("shape", SIZES, ids=lambda shape: f"{shape[0]}x{shape[1]}")
def test_full_rmap(benchmark, shape, is_noisy):
    free = drawn(shape, is_noisy=is_noisy)
    rectangles = rmap(free)
    benchmark.pedantic(rmap, args=(free,), rounds=20, warmup_rounds=2)

    ratio = benchmark.stats.stats.min / transform_seconds(free)
    benchmark.extra_info |= {
        "rectangles": len(rectangles),
        "free": float(free.mean()),
        "ratio_to_distance_transform": ratio,
    }
    assert ratio <= 40


@pytest.mark.parametrize("is_literal", [False, True], ids=["lazy", "literal"])
def test_literal_loop_beside_it(benchmark, is_literal):
    free = drawn((60, 70), is_noisy=True)
    rmap(free)
    boxes = benchmark.pedantic(naive.rmap if is_literal else lambda mask: rmap(mask).boxes, args=(free,), rounds=2)

    assert [tuple(box) for box in np.asarray(boxes).tolist()] == naive.rmap(free)
