"""A finished run on a small data set, for the tests of the page and for the browser."""

from dataclasses import dataclass

import pytest

from rectmerge.alignment import Alignment, Candidate
from rectmerge.similarity import Similarity
from scenarios.bench.contenders import Contender
from scenarios.dataset.generate import generate
from scenarios.dataset.reader import open_dataset
from scenarios.suites.spec import Seeds
from tests.scenarios.known_answers import run_pairs
from tests.scenarios.tiny_suite import SHIFT, TinySuite


@dataclass(frozen=True, kw_only=True)
class FixedPlacement:
    """Lays B where it belongs, or some cells aside."""

    name: str = "placing"
    aside: float = 0.0
    verdict: str = "accepted"
    confidence: float = 0.75

    def align(self, a, b, *, scale, rng):
        pixels = Similarity(1.0, 0.0, SHIFT[0] + self.aside, SHIFT[1])
        best = Candidate.from_pixels(pixels, a, b, confidence=self.confidence)
        return Alignment(
            verdict=self.verdict,
            reason="<b>as told</b> & more",
            method=self.name,
            candidates=(best,),
            confidence=self.confidence,
        )


METHODS = [
    Contender(label="good", method=FixedPlacement()),
    Contender(label="bad", method=FixedPlacement(aside=20.0, confidence=0.9)),
    Contender(label="bad-tuned", method=FixedPlacement(verdict="rejected", confidence=0.1)),
]


@pytest.fixture(scope="session")
def report_run(tmp_path_factory):
    """Three methods on three pairs of one place and three of two."""
    root = tmp_path_factory.mktemp("report")
    generate(TinySuite(seeds=Seeds(count=3)), root / "set")
    sources = open_dataset(root / "set")
    run_pairs(
        sources, METHODS, root / "run", suite="tiny", about={"dataset": str(root / "set")}, command="rectbench run tiny"
    )
    return root / "run"
