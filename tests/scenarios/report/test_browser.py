"""The page in a real browser: what a click, a choice and the slider do, and that it asks the network for nothing."""

import shutil

import pytest

from scenarios.report.page import write_report
from tests import browser

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("chromedriver") is None, reason="no chromedriver: apt install chromium-driver"),
]


@pytest.fixture(scope="module")
def page(report_run, tmp_path_factory):
    """The report, open in a browser that writes down its requests and its console."""
    out = tmp_path_factory.mktemp("browser") / "report.html"
    write_report([report_run], out)
    opened = browser.start()
    opened.get(out.as_uri())
    yield opened
    opened.quit()


def all_of(page, css):
    return page.find_elements("css selector", css)


def methods_in_order(page):
    return [cell.text for cell in all_of(page, "table.sortable tbody th")]


def canvas(page):
    return page.execute_script("return document.querySelector('.card canvas').toDataURL()")


def slide_to(page, value):
    page.execute_script(
        "const s = document.querySelector('.card input'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))",
        value,
    )


def choose(page, name, value):
    from selenium.webdriver.support.ui import Select

    Select(page.find_element("id", f"filter-{name}")).select_by_visible_text(value)


def test_a_click_on_a_heading_sorts_and_another_turns_it_round(page):
    heading = next(button for button in all_of(page, "table.sortable th button") if button.text == "wrong")

    heading.click()
    most_first = methods_in_order(page)
    heading.click()

    assert most_first[0] == "bad"
    assert methods_in_order(page)[-1] == "bad"
    assert heading.find_element("xpath", "..").get_attribute("aria-sort") == "ascending"


def test_filters_choose_what_the_gallery_shows(page):
    everything = len(all_of(page, ".card"))
    choose(page, "method", "good")
    choose(page, "outcome", "right-accepted")

    assert everything == 18
    assert len(all_of(page, ".card")) == 3
    assert all("good" in title.text for title in all_of(page, ".card h4"))
    assert page.find_element("id", "shown-count").text == "3 answers"
    choose(page, "method", "all")
    choose(page, "outcome", "all")


def test_the_slider_fades_between_a_both_b_and_the_truth(page):
    choose(page, "method", "bad")
    choose(page, "outcome", "wrong-accepted")
    seen = []
    for stop in (0, 1, 2, 3):
        slide_to(page, stop)
        seen.append(canvas(page))

    assert len(set(seen)) == 4
    choose(page, "method", "all")
    choose(page, "outcome", "all")


@pytest.mark.parametrize("width", [360, 1200])
def test_the_page_is_no_wider_than_the_screen(page, width):
    assert browser.width_on_a_screen(page, width) <= width


def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(page):
    asked = browser.requests(page)

    assert any(url.startswith("file:") for url in asked)
    assert not [url for url in asked if not url.startswith(("file:", "data:"))]
    assert not browser.complaints(page)
