import pytest

from rectmerge import methods
from rectmerge.cli import console
from rectmerge.drawing import many_maps
from rectmerge.drawing import maps as picture
from tests.rectmerge.cli.answers import FixedAnswers
from tests.rectmerge.cli.many import MAPS, Judge, rectmerge, save_fleet


@pytest.fixture
def small_pictures(monkeypatch):
    """Draw small: what is written where does not depend on it, and it is faster."""
    for module in (picture, many_maps):
        monkeypatch.setattr(module, "SIDE_PX", 300)


@pytest.fixture
def answer(monkeypatch):
    """Make every method give the same answer."""

    def give(verdict: str, candidates: int = 1) -> None:
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: FixedAnswers(verdict, candidates))

    return give


@pytest.fixture
def saved(tmp_path, monkeypatch):
    """Write a fleet's maps to files, and let every method answer from its truth; return the files by name."""

    def save(made, **oracle):
        files = save_fleet(tmp_path, made)
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: Judge(made, **oracle))
        return files

    return save


@pytest.fixture(scope="session")
def merged_many(tmp_path_factory):
    """The folder of a merge of the three committed maps."""
    out = tmp_path_factory.mktemp("many") / "out"
    assert rectmerge("merge", *MAPS, "-o", out, "-q") == console.YES
    return out
