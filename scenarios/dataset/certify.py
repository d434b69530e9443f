"""Certificates for the pairs of a data set that the default method accepts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rectmerge.aligning import align, searched_scale
from rectmerge.alignment import Certificate, Certifies
from rectmerge.methods import DEFAULT_METHOD, make_method
from scenarios.dataset.reader import open_dataset
from scenarios.execution.terminal import table
from scenarios.pairs.pair import MapPair

OPEN = "left open"


def certify_dataset(
    dataset: str | Path, *, every: int = 1, seconds: float = 10.0, on_pair: Callable[[], None] = lambda: None
) -> list[tuple[str, Certificate]]:
    """Put the default method to every n-th pair, and certify its accepted answers.

    Parameters
    ----------
    dataset
        Its folder.
    every
        1 takes all pairs.
    seconds
        Wall time for each certificate.
    on_pair
        Called after each pair that was asked.

    Returns
    -------
    list
        (pair_id, certificate) of the accepted pairs, in the data set's order.

    Raises
    ------
    DatasetError
        If it cannot be read.
    """
    found = []
    for source in open_dataset(dataset)[::every]:
        for pair in source.pairs():
            certificate = _certified(pair, seconds)
            found += [] if certificate is None else [(pair.pair_id, certificate)]
            on_pair()
    return found


def certificate_table(found: Sequence[tuple[str, Certificate]]) -> str:
    """Format certificates: a line for each pair, and the count of each kind."""
    rows = [
        [pair_id, _kind(certificate), f"{certificate.seconds:.1f}", str(certificate)] for pair_id, certificate in found
    ]
    kinds = [_kind(certificate) for _, certificate in found]
    counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in ("certified", "rivalled", OPEN))
    return f"{table(['pair', 'answer', 's', 'what was shown'], rows)}\nof {len(found)} accepted pairs: {counts}"


def _certified(pair: MapPair, seconds: float) -> Certificate | None:
    answer, method = align(pair.a, pair.b), make_method(DEFAULT_METHOD)
    if not (answer and isinstance(method, Certifies)):
        return None
    scale = searched_scale("auto", answer.scale)
    return method.certify(pair.a, pair.b, answer.candidates[0].pixels, scale=scale, seconds=seconds)


def _kind(certificate: Certificate) -> str:
    if certificate:
        return "certified"
    return OPEN if certificate.counterexample is None else "rivalled"
