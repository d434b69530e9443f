"""A finished run of two methods on a small data set, and a registry that knows their class."""

from importlib.metadata import EntryPoint

import pytest

from rectmerge import methods
from scenarios.bench.contenders import Contender
from scenarios.dataset.generate import generate
from scenarios.dataset.reader import open_dataset
from scenarios.suites.spec import Seeds
from tests.scenarios.known_answers import run_pairs
from tests.scenarios.report.conftest import FixedPlacement
from tests.scenarios.tiny_suite import TinySuite

METHODS = [
    Contender(label="good", method=FixedPlacement()),
    Contender(label="aside", method=FixedPlacement(aside=20.0, confidence=0.9)),
]


@pytest.fixture(scope="package")
def finished(tmp_path_factory):
    """A folder with the data set ``tiny``, three related and three unrelated pairs, and its ``run``."""
    root = tmp_path_factory.mktemp("submitted")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: b"a picture")
        generate(TinySuite(seeds=Seeds(count=3)), root / "tiny")
    run_pairs(
        open_dataset(root / "tiny"),
        METHODS,
        root / "run",
        suite="tiny",
        about={"dataset": str(root / "tiny")},
        command="rectbench run tiny",
    )
    return root


@pytest.fixture
def registry(monkeypatch):
    """Register the class of the run's methods."""
    point = EntryPoint(name="placing", value="tests.scenarios.report.conftest:FixedPlacement", group=methods.GROUP)
    known = methods.available()
    monkeypatch.setattr(methods, "available", lambda: {**known, "placing": point})
