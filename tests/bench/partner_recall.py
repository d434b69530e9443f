"""Recall of likely partners among many maps: ``python -m tests.bench.partner_recall SETS...``.

Of all maps of some data sets at once: the share of pairs of a known overlap that the signatures put among the five
most similar of either map, the share of maps that have a partner there, and what a map costs. Nothing is asserted.
"""

from __future__ import annotations

import sys
import time
from itertools import chain

import numpy as np

from rectmerge.fleet.params import PartnerParams
from rectmerge.fleet.signature import partners, signature, similarities
from rectmerge.io.map_file import read_map
from scenarios.dataset.reader import open_dataset

BEST = 5
LEAST_OVERLAP = 0.3


def main(sets: list[str]) -> None:
    """Print the recall, and the seconds of a map."""
    rows = [source.row() for source in chain.from_iterable(open_dataset(name) for name in sets)]
    files = {str(path): path for row in rows for path in (row.folder / row.map_a, row.folder / row.map_b)}
    number = {name: k for k, name in enumerate(files)}
    true = {
        tuple(sorted(number[str(row.folder / name)] for name in (row.map_a, row.map_b)))
        for row in rows
        if row.related and (row.overlap or 0.0) >= LEAST_OVERLAP
    }
    grids = (read_map(path) for path in files.values())
    params, spent, words = PartnerParams(), 0.0, []
    for grid in grids:
        began = time.process_time()
        words.append(signature(grid, params))
        spent += time.process_time() - began
    began = time.process_time()
    found = set(partners(similarities(words, params), BEST))
    spent += time.process_time() - began
    recall = np.mean([pair in found for pair in true])
    related, reached = (set(chain.from_iterable(some)) for some in (true, true & found))
    print(  # noqa: T201
        f"{len(files)} maps, {len(true)} pairs of overlap >= {LEAST_OVERLAP:g}: recall at {BEST} {recall:.0%}; "
        f"{len(reached) / len(related):.0%} of the maps with such a partner are asked with one; "
        f"{1000 * spent / len(files):.0f} ms of CPU a map"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
