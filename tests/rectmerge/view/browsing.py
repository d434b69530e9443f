"""What a person does with the page in a browser, and what the page then tells."""

import json

import numpy as np

from rectmerge.io.map_file import read_map
from rectmerge.similarity import Similarity


def opened(browser, folder):
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get((folder / "view.html").as_uri())
    WebDriverWait(browser, 10).until(lambda page: page.find_element("id", "maps").get_attribute("data-zoom"))
    return browser


def element(page, css):
    return page.find_element("css selector", css)


def by_hand(page):
    element(page, "[value=hand] + span").click()


def picture(page):
    return page.execute_script("return document.getElementById('maps').toDataURL()")


def zoom(page):
    return float(element(page, "#maps").get_attribute("data-zoom"))


def value(page, name):
    return element(page, f"#{name}").get_property("value")


def numbers(page, name="pixels"):
    return [float(word) for word in value(page, name).partition("=")[2].split(",")]


def placed(page):
    a, b, tx, ty = numbers(page)
    return Similarity.from_matrix([[a, -b, tx], [b, a, ty]])  # refuses what is no similarity, or a mirrored one


def saved_placement(folder, k):
    return Similarity.from_matrix(json.loads((folder / "alignment.json").read_text())["candidates"][k]["pixels"])


def close(first, second):
    return np.allclose(first.matrix, second.matrix, rtol=1e-8, atol=1e-8)


def drag(page, start, by, *, key=None):
    """Drag from a point of the canvas, as seen from its middle, in steps as a hand does."""
    from selenium.webdriver import ActionChains

    actions = ActionChains(page, duration=20)
    if key is not None:
        actions.key_down(key)
    actions.move_to_element_with_offset(element(page, "#maps"), *start).click_and_hold()
    for _ in range(4):
        actions.move_by_offset(by[0] / 4, by[1] / 4)
    actions.release()
    if key is not None:
        actions.key_up(key)
    actions.perform()


def turn_wheel(page, delta, **keys):
    page.execute_script(
        "const c = document.getElementById('maps'), box = c.getBoundingClientRect();"
        "c.dispatchEvent(new WheelEvent('wheel', {deltaY: arguments[0], cancelable: true, bubbles: true,"
        "clientX: box.left + 150, clientY: box.top + 100, ...arguments[1]}))",
        delta,
        keys,
    )


def enter(page, name, text):
    from selenium.webdriver.common.keys import Keys

    field = element(page, f"#{name}")
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys(text, Keys.ENTER)


def middle_of_b(page, folder):
    """B's middle on A in A's map frame: B's map is known from edge to edge."""
    a, b = (read_map(folder.parent / f"building_{name}.yaml") for name in "ab")
    rows, cols = np.nonzero(~b.unknown)
    return a, b, a.pixel_to_map(placed(page).apply([(cols.min() + cols.max()) / 2, (rows.min() + rows.max()) / 2]))
