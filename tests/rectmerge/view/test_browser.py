"""The page in a real browser: what pointers, keys and buttons do, and that its numbers are right."""

import math
import shutil

import numpy as np
import pytest

from rectmerge.cli.console import run
from rectmerge.cli.main import app
from rectmerge.grid import pixels_to_map_frame
from rectmerge.io.map_file import read_map
from tests import browser as pages
from tests.rectmerge.view.browsing import (
    by_hand,
    close,
    drag,
    element,
    enter,
    middle_of_b,
    numbers,
    opened,
    picture,
    placed,
    saved_placement,
    turn_wheel,
    value,
    zoom,
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("chromedriver") is None, reason="no chromedriver: apt install chromium-driver"),
]


@pytest.fixture(scope="module")
def browser():
    """A browser that writes down its requests and its console."""
    browser = pages.start()
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def folder(write_answer, tmp_path_factory):
    """An ambiguous answer with its page."""
    folder = write_answer(tmp_path_factory.mktemp("browser"), verdict="ambiguous")
    assert run(app, "rectmerge", ["view", str(folder), "--no-open"]) == 0
    return folder


@pytest.fixture
def page(browser, folder):
    """The page, opened anew."""
    return opened(browser, folder)


def test_the_slider_fades_from_a_over_both_to_b(page):
    seen = []
    for stop in (0, 1, 2):
        page.execute_script(
            "const s = document.getElementById('fade'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))",
            stop,
        )
        seen.append(picture(page))

    assert len(set(seen)) == 3


def test_rectangles_are_drawn_on_demand(page):
    before = picture(page)
    element(page, "#rectangles").click()

    assert picture(page) != before


def test_candidates_are_stepped_through_by_buttons_and_arrow_keys(page, folder):
    from selenium.webdriver.common.keys import Keys

    seen = [picture(page)]
    assert close(placed(page), saved_placement(folder, 0))
    element(page, "#next").click()
    seen.append(picture(page))
    assert close(placed(page), saved_placement(folder, 1))
    element(page, "body").send_keys(Keys.ARROW_RIGHT)
    seen.append(picture(page))
    assert close(placed(page), saved_placement(folder, 2))
    element(page, "body").send_keys(Keys.ARROW_RIGHT)
    assert close(placed(page), saved_placement(folder, 0))
    element(page, "#previous").click()
    assert close(placed(page), saved_placement(folder, 2))

    assert len(set(seen)) == 3
    assert element(page, "#candidates [aria-current=true] b").text == "3"


@pytest.mark.parametrize("zoomed", [0, -400])
def test_a_drag_by_hand_moves_b_by_as_many_cells_as_the_screen_shows(page, folder, zoomed):
    turn_wheel(page, zoomed)
    by_hand(page)
    before = placed(page)
    drag(page, (-120, 40), (60, -32))

    after = placed(page)
    assert [after.tx - before.tx, after.ty - before.ty] == pytest.approx([60 / zoom(page), -32 / zoom(page)], abs=1e-6)
    assert (after.scale, after.angle) == pytest.approx((before.scale, before.angle))


def test_a_drag_of_the_view_leaves_b_where_it_is_on_a(page, folder):
    before = picture(page)
    drag(page, (0, 0), (50, 20))
    turn_wheel(page, -200)
    element(page, "#zoom-out").click()

    assert picture(page) != before
    assert close(placed(page), saved_placement(folder, 0))
    element(page, "#fit").click()
    assert picture(page) == before


def test_shift_drag_and_the_handle_turn_about_the_middle_of_b(page, folder):
    from selenium.webdriver.common.keys import Keys

    by_hand(page)
    *_, at_first = middle_of_b(page, folder)
    before = placed(page)
    drag(page, (200, -100), (0, 120), key=Keys.SHIFT)
    turned = placed(page)
    u, v = page.execute_script("return handle()")
    canvas = element(page, "#maps").size
    drag(page, (round(u + 1 - canvas["width"] / 2), round(v + 1 - canvas["height"] / 2)), (-60, 30))
    again = placed(page)

    assert abs(math.remainder(turned.angle - before.angle, math.tau)) > 0.1
    assert abs(math.remainder(again.angle - turned.angle, math.tau)) > 0.1
    assert again.scale == pytest.approx(before.scale)
    assert middle_of_b(page, folder)[2] == pytest.approx(at_first, abs=1e-6)


def test_wheels_scale_and_turn_b_by_hand_and_zoom_else(page):
    by_hand(page)
    before, zoomed = placed(page), zoom(page)
    turn_wheel(page, -100, ctrlKey=True)
    scaled = placed(page)
    turn_wheel(page, 100, shiftKey=True)
    turned = placed(page)

    assert scaled.scale == pytest.approx(before.scale * math.exp(0.15))
    assert turned.angle == pytest.approx(scaled.angle + 0.06)
    assert zoom(page) == zoomed
    turn_wheel(page, -100)
    assert zoom(page) > zoomed
    assert close(placed(page), turned)


def test_two_fingers_move_turn_and_scale_b_at_once(page):
    by_hand(page)
    before = placed(page)
    box = page.execute_script("return document.getElementById('maps').getBoundingClientRect().toJSON()")

    def touch(kind, *points):
        at = [{"x": box["left"] + x, "y": box["top"] + y, "id": k} for k, (x, y) in enumerate(points)]
        page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

    touch("touchStart", (100, 300))
    touch("touchStart", (100, 300), (200, 300))
    touch("touchMove", (100, 300), (180, 340))
    touch("touchMove", (100, 300), (100, 450))
    touch("touchEnd")

    after = placed(page)
    assert after.scale == pytest.approx(1.5 * before.scale, rel=1e-6)
    assert math.remainder(after.angle - before.angle - math.pi / 2, math.tau) == pytest.approx(0, abs=1e-6)


def test_fields_change_one_thing_each(page, folder):
    a, b, (x, y) = middle_of_b(page, folder)
    enter(page, "rotation", "30")
    enter(page, "scale", "1.5")
    assert middle_of_b(page, folder)[2] == pytest.approx([x, y], abs=1e-6)
    enter(page, "x", "3.25")
    enter(page, "y", "-1")

    assert middle_of_b(page, folder)[2] == pytest.approx([3.25, -1.0], abs=1e-6)
    assert placed(page).scale == pytest.approx(1.5)
    assert math.degrees(pixels_to_map_frame(placed(page), a, b).angle) == pytest.approx(30)
    enter(page, "scale", "-2")
    assert placed(page).scale == pytest.approx(1.5)


def test_keys_and_buttons_do_what_pointers_do(page):
    from selenium.webdriver.common.keys import Keys

    by_hand(page)
    before = placed(page)
    element(page, "#maps").send_keys(Keys.ARROW_RIGHT)
    assert placed(page).tx - before.tx == pytest.approx(1 / zoom(page))
    element(page, "[data-move='0,1']").click()
    assert placed(page).ty - before.ty == pytest.approx(1)
    element(page, "[data-turn='90']").click()
    assert placed(page).angle - before.angle == pytest.approx(-math.pi / 2)  # counter-clockwise to the eye
    element(page, "[data-scale='1.01']").click()
    assert placed(page).scale == pytest.approx(1.01 * before.scale)


def test_reset_goes_back_to_the_candidate_that_was_shown(page, folder):
    by_hand(page)
    element(page, "#next").click()
    drag(page, (0, 0), (40, 40))
    assert element(page, "#reset").text == "Reset to candidate 2"
    element(page, "#reset").click()

    assert close(placed(page), saved_placement(folder, 1))
    assert len(page.find_elements("css selector", "#candidates button")) == 3


def test_what_is_placed_by_hand_is_kept_while_candidates_are_looked_at(page):
    by_hand(page)
    drag(page, (0, 0), (40, 40))
    mine = placed(page)
    element(page, "#next").click()
    element(page, "#previous").click()

    assert close(placed(page), mine)


def test_numbers_pasted_back_place_b_there(page, folder):
    a, b = (read_map(folder.parent / f"building_{name}.yaml") for name in "ab")
    text = value(page, "pixels")
    element(page, "#next").click()
    enter(page, "pasted", text)
    assert close(placed(page), saved_placement(folder, 0))

    guess = numbers(page, "guess")
    expected = pixels_to_map_frame(saved_placement(folder, 0), a, b)
    assert guess == pytest.approx([expected.tx, expected.ty, expected.angle], abs=1e-7)
    element(page, "[data-turn='90']").click()
    enter(page, "pasted", ",".join(map(str, guess)))
    assert np.allclose(placed(page).matrix, saved_placement(folder, 0).matrix, atol=1e-6)

    for nonsense in ("1,2", "a,b,c,d", "0,0,3,4", ""):
        enter(page, "pasted", nonsense)
        assert element(page, "#refused").text
        assert np.allclose(placed(page).matrix, saved_placement(folder, 0).matrix, atol=1e-6)


def test_commands_hold_the_maps_and_the_numbers(page):
    option = value(page, "pixels")

    assert value(page, "check").startswith("rectmerge check ")
    assert value(page, "check").endswith(f"building_b.yaml {option}")
    assert value(page, "merge").endswith(f"building_b.yaml {option} -o by-hand")


def test_copying_says_so(page):
    element(page, "[data-copy=pixels]").click()

    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(page, 5).until(lambda page: element(page, "#copied").text == f"Copied: {value(page, 'pixels')}")


def test_without_a_candidate_a_hand_places_b(browser, write_answer, tmp_path):
    folder = write_answer(tmp_path, verdict="rejected", candidates=0)
    assert run(app, "rectmerge", ["view", str(folder), "--no-open"]) == 0
    page = opened(browser, folder)
    before = placed(page)
    drag(page, (0, 0), (40, 0))

    assert before.scale == pytest.approx(1.2)
    assert placed(page).tx - before.tx == pytest.approx(40 / zoom(page))
    element(page, "#reset").click()
    assert close(placed(page), before)


@pytest.mark.parametrize("width", [360, 1200])
def test_the_page_is_no_wider_than_the_screen(page, width):
    by_hand(page)
    assert pages.width_on_a_screen(page, width) <= width


def test_on_a_screen_of_800_by_800_the_numbers_show_without_scrolling(page):
    metrics = {"width": 800, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    lowest = "return document.getElementById(arguments[0]).getBoundingClientRect().bottom + scrollY"
    bottoms = {name: page.execute_script(lowest, name) for name in ("candidates", "pixels", "guess", "check", "merge")}
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    assert max(bottoms.values()) <= 800, bottoms


def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(page):
    asked = pages.requests(page)

    assert any(url.startswith("file:") for url in asked)
    assert not [url for url in asked if not url.startswith(("file:", "data:"))]
    assert not pages.complaints(page)
