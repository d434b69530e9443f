import pytest

from rectmerge import methods
from rectmerge.drawing import maps as picture
from tests.rectmerge.cli.answers import FixedAnswers


@pytest.fixture
def small_pictures(monkeypatch):
    """Draw small: what is written where does not depend on it, and it is faster."""
    monkeypatch.setattr(picture, "SIDE_PX", 300)


@pytest.fixture
def answer(monkeypatch):
    """Make every method give the same answer."""

    def give(verdict: str, candidates: int = 1) -> None:
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: FixedAnswers(verdict, candidates))

    return give
