import pytest

from scenarios.gallery.how_it_works import MEETINGS, NAMES, Explained, draw_meetings, office_pair
from scenarios.gallery.page_picture import small_png
from tests.test_docs import ROOT


@pytest.mark.sim
def test_the_truth_meets_walls_and_a_rival_contradicts_more():
    office = Explained.from_pair(office_pair())
    best, rival = (_share(draw_meetings(office, each.pixels), "wall matched") for each in (office.best, office.rival))

    assert office.alignment.verdict == "accepted"
    assert best > 0.8 > rival
    assert len(small_png(draw_meetings(office, office.best.pixels))) < 120_000


def test_the_pictures_of_the_page_are_small_and_all_shown():
    folder, page = ROOT / "docs" / "how-it-works", (ROOT / "docs" / "how-it-works.md").read_text(encoding="utf-8")
    sizes = [(folder / name).stat().st_size for name in NAMES]

    assert max(sizes) < 120_000
    assert sum(sizes) < 500_000
    assert [name for name in NAMES if f"(how-it-works/{name})" not in page] == []


def _share(picture, kind):
    """Share of a kind among the walls that both maps know."""
    counts = {name: (picture == color).all(axis=2).sum() for name, color in MEETINGS.items()}
    return counts[kind] / sum(counts[name] for name in ("wall matched", "wall contradicted", "beside"))
