import re

import numpy as np
import pytest

from rectmerge.fleet.many import align_many
from rectmerge.view.fleet_page import html
from tests.rectmerge.fleet.fleets import Oracle, fleet


@pytest.fixture(scope="module")
def shown():
    made = fleet(1, home=4, other=1)
    made.maps = {name.replace("other0", "<b>x</b>"): grid for name, grid in made.maps.items()}
    for facts in (made.place, made.poses):
        facts["<b>x</b>"] = facts.pop("other0")
    lies = {("home1", "<b>x</b>"): made.poses["home1"]}
    graph = align_many(made.maps, method=Oracle(made, lies=lies))
    return made, graph, html(graph, made.maps)


def test_the_page_holds_everything_and_names_are_not_markup(shown):
    _, graph, page = shown

    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert "<b>x</b>" not in page
    assert "&lt;b&gt;x&lt;/b&gt;" in page
    for reason in graph.left_out.values():
        assert reason.split("<")[0] in page


def test_every_map_of_a_component_is_a_layer_at_its_place(shown):
    made, graph, page = shown
    found = re.findall(r'<image id="map-1-(\d)" width="(\d+)" height="(\d+)".*?matrix\((.*?)\)', page)

    assert sorted(int(index) for index, *_ in found) == [0, 1, 2, 3]
    for index, width, height, numbers in found:
        a, c, b, d, tx, ty = map(float, numbers.split())
        name = graph.components[0][int(index)]
        rows, cols = made.maps[name].shape
        middle = np.array([[a, b, tx], [c, d, ty]]) @ [int(width) / 2, int(height) / 2, 1]
        expected = graph.placements[name].pixels.apply([(cols - 1) / 2, (rows - 1) / 2])
        assert middle == pytest.approx(expected, abs=0.6)


def test_every_layer_has_a_slider_and_every_asked_pair_a_row(shown):
    _, graph, page = shown

    assert page.count('data-layer="map-1-') == 4
    assert page.count("<tr><td>") == graph.asked
    drawn = [answer for answer in graph.pairs.asked.values() if answer.status in ("used", "promoted", "thrown out")]
    assert page.count("<line ") == len(drawn)
    assert '<line class="thrown-out"' in page
