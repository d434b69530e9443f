import json
import re
import shutil

import numpy as np
import pytest

from rectmerge.io.map_file import read_map
from tests import browser as pages
from tests.rectmerge.cli.answers import rectmerge
from tests.rectmerge.elastic.merges import merge_bent_maps
from tests.rectmerge.view.browsing import by_hand, element, opened, picture


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A merge of maps that bend, with its page."""
    folder = merge_bent_maps(tmp_path_factory.mktemp("bent"))
    assert rectmerge("view", folder, "--no-open") == 0
    return folder


def maps_of(folder):
    page = (folder / "view.html").read_text(encoding="utf-8")
    return json.loads(re.search(r'id="answer-data">(.*?)</script>', page, re.DOTALL).group(1))["maps"]


def test_the_page_holds_map_b_without_its_bend(folder):
    maps = maps_of(folder)

    assert maps["bent"].startswith("data:image/png")
    assert maps["bent"] != maps["b"]
    scales = [np.reshape(maps[name], (2, 3))[0, 0] for name in ("to_b", "to_bent")]
    assert scales[1] == pytest.approx(scales[0], rel=0.1)
    assert np.abs(np.reshape(maps["to_bent"], (2, 3))[:, 2]).max() < max(read_map(folder / "b.yaml").shape)


def test_a_merge_without_a_bend_has_no_second_picture(folder, tmp_path):
    maps = [folder / "a.yaml", folder / "b.yaml"]
    pixels = "--pixels=" + ",".join(map(str, np.ravel(json.loads((folder / "alignment.json").read_text())["pixels"])))
    assert rectmerge("merge", *maps, pixels, "-o", tmp_path, "--unbend", "never") == 0

    assert rectmerge("view", tmp_path, "--no-open") == 0

    assert "bent" not in maps_of(tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromedriver") is None, reason="no chromedriver: apt install chromium-driver")
def test_a_slider_fades_the_first_candidate_from_map_b_to_map_b_unbent(folder):
    browser = pages.start()
    try:
        page = opened(browser, folder)
        shown = []
        for value in ("1", "0.5", "0"):
            page.execute_script(
                "const bend = document.getElementById('bend'); bend.value = arguments[0];"
                "bend.dispatchEvent(new Event('input'))",
                value,
            )
            shown.append(picture(page))

        assert len(set(shown)) == 3
        assert element(page, "#bending").is_displayed()
        by_hand(page)
        element(page, "[data-move='1,0']").click()
        assert not element(page, "#bending").is_displayed()
        assert pages.complaints(page) == []
    finally:
        browser.quit()
