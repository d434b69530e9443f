"""Signature of a map, words of neighbouring rectangles, by which likely partners are found without asking every pair.

A word holds the aspects of two neighbouring maximal empty rectangles, the ratio of their sizes and their offset, in
the frame and the size of the first one: free of rotation, scale and mirror image. Maps are compared as texts are, by
the cosine of their vectors of tf-idf (G. Salton and C. Buckley, 1988, DOI 10.1016/0306-4573(88)90021-0).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rectmerge.fleet.params import PartnerParams
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.params import Params
from rectmerge.robust.prepared_map import PreparedMap

BITS = 8  # of each of a word's five numbers
CHUNK_WORDS = 4096  # compared at a time, so that memory does not grow with the vocabulary


class Signature(NamedTuple):
    """Words of a map, ascending, and how often each occurs; shape (N,) each."""

    words: NDArray[np.int64]
    counts: NDArray[np.float64]


def signature(grid: OccupancyGrid, params: PartnerParams) -> Signature:
    """Return the words of a map; none where no wall borders on free space."""
    frames = PreparedMap.from_grid(grid, Params()).frames
    if not frames or len(frames[0].boxes) < 2:
        return Signature(np.empty(0, np.int64), np.empty(0))
    frame = frames[0]
    axes = np.exp(-1j * frame.angle) * (frame.boxes[:, 0] + 1j * frame.boxes[:, 1])
    measures = _neighbour_measures(axes, frame.boxes[:, 2], frame.boxes[:, 3], params)
    words, weights = _words(measures, params)
    unique, inverse = np.unique(words, return_inverse=True)
    return Signature(unique, np.bincount(inverse, weights, minlength=len(unique)).astype(np.float64))


def _neighbour_measures(
    centres: NDArray[np.complex128], width: NDArray[np.float64], height: NDArray[np.float64], params: PartnerParams
) -> NDArray[np.float64]:
    """Return the five measures of each pair of neighbours in steps, shape (N, 5)."""
    size = np.sqrt(width * height)
    apart = centres - centres[:, None]  # (n, n), from the row's rectangle to the column's
    distance = np.maximum(np.abs(apart.real), np.abs(apart.imag)) / size[:, None]
    np.fill_diagonal(distance, np.inf)
    near = np.argsort(distance, axis=1, kind="stable")[:, : params.neighbours]
    first, rank = np.nonzero(np.take_along_axis(distance, near, axis=1) <= params.reach_sizes)
    second = near[first, rank]
    offset = apart[first, second] / size[first]
    is_upright = width[first] < height[first]  # the first's long side is the word's first axis
    along = np.where(is_upright, np.abs(offset.imag), np.abs(offset.real))
    across = np.where(is_upright, np.abs(offset.real), np.abs(offset.imag))
    aspect = np.log(width / height)
    measures: NDArray[np.float64] = np.stack(
        [
            np.abs(aspect[first]) / (2 * params.size_step),
            np.where(is_upright, -aspect[second], aspect[second]) / (2 * params.size_step),
            np.log(size[second] / size[first]) / params.size_step,
            along / params.offset_step,
            across / params.offset_step,
        ],
        axis=1,
    )
    return measures


def _words(measures: NDArray[np.float64], params: PartnerParams) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Quantise measures to words with their weights, beside each its neighbours across the nearest borders."""
    base = np.floor(measures).astype(np.int64)
    from_middle = measures - base - 0.5
    codes, weights = [base], [np.ones(len(base))]
    borders = np.argsort(-np.abs(from_middle), axis=1, kind="stable")[:, : params.border_words]
    rows = np.arange(len(base))
    for column in borders.T:
        beside = base.copy()
        beside[rows, column] += np.where(from_middle[rows, column] > 0, 1, -1)
        codes.append(beside)
        weights.append(np.full(len(base), params.border_weight))
    numbers = np.clip(np.concatenate(codes) + 2 ** (BITS - 1), 0, 2**BITS - 1)
    return numbers @ 2 ** (BITS * np.arange(5, dtype=np.int64)), np.concatenate(weights)


def similarities(signatures: Sequence[Signature], params: PartnerParams) -> NDArray[np.float64]:
    """Return the cosine of every two maps' vectors of tf-idf, shape (N, N); the diagonal is minus infinity."""
    count = len(signatures)
    vocabulary, word = np.unique(np.concatenate([one.words for one in signatures]), return_inverse=True)
    owner = np.repeat(np.arange(count), [len(one.words) for one in signatures])
    frequency = np.bincount(word, minlength=len(vocabulary))
    says_something = (frequency > 1) & (frequency < max(2.5, params.max_document_share * count))
    rarity = np.where(says_something, np.log(count / np.maximum(frequency, 1)), 0.0)
    value = np.log1p(np.concatenate([one.counts for one in signatures])) * rarity[word]
    value /= np.maximum(np.sqrt(np.bincount(owner, value**2, minlength=count)), 1e-12)[owner]
    cosine = np.zeros((count, count))
    order = np.argsort(word, kind="stable")
    for start in range(0, len(vocabulary), CHUNK_WORDS):
        some = order[slice(*np.searchsorted(word[order], [start, start + CHUNK_WORDS]))]
        dense = np.zeros((count, CHUNK_WORDS), np.float32)
        dense[owner[some], word[some] - start] = value[some]
        cosine += dense @ dense.T
    np.fill_diagonal(cosine, -np.inf)
    return cosine


def partners(cosine: NDArray[np.float64], each: int) -> list[tuple[int, int]]:
    """List the pairs (i, j), i < j, of each map with its `each` most similar ones."""
    order = np.argsort(-cosine, axis=1, kind="stable")[:, : min(each, len(cosine) - 1)]
    return sorted({(min(i, int(j)), max(i, int(j))) for i, row in enumerate(order) for j in row})
