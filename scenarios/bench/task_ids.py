"""Ids of tasks: hashes of all that determines a row, apart from the code and the limits."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence

from scenarios.bench.contenders import Contender
from scenarios.dataset.content_hash import content_hash
from scenarios.pairs.pair import PairSource

TaskKey = tuple[str, str]  # a pair's id and a contender's label
ID_DIGITS = 16  # of the hash, hexadecimal: two of two million tasks share an id with probability 1e-7


def task_ids(source: PairSource, contenders: Sequence[Contender], *, seed: int) -> dict[TaskKey, str]:
    """Return the id of each of a source's tasks.

    A task is determined by what defines the source (for a suite the scenario as it was resolved and its seed, for a
    row of a data set the row and the sizes of its files), the pair, the contender's label, method and fields, and the
    seed of its answer.
    """
    source_hash = content_hash(source)
    methods = {contender.label: content_hash(contender) for contender in contenders}
    return {
        (pair_id, label): content_hash([source_hash, pair_id, method, seed])[:ID_DIGITS]
        for pair_id in source.pair_ids
        for label, method in methods.items()
    }


def run_id(sources: Iterable[PairSource], contenders: Sequence[Contender], *, suite: str, seed: int) -> tuple[str, int]:
    """Return the id of a run, a hash of all of its tasks in their order, and the number of its pairs."""
    whole = hashlib.sha256(content_hash([suite, seed, *contenders]).encode())
    pairs = 0
    for source in sources:
        whole.update(content_hash(source).encode())
        pairs += len(source.pair_ids)
    return whole.hexdigest()[:ID_DIGITS], pairs
