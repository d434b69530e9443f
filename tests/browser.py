"""A real browser for tests of pages: what it shows, and that it asks the network for nothing."""

import json
import shutil


def start():
    """Start a browser that writes down its requests and its console."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1200,1000"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


def width_on_a_screen(page, width):
    """Return how wide the page is on a screen of this width: a phone's where it is narrow."""
    metrics = {"width": width, "height": 800, "deviceScaleFactor": 2, "mobile": width < 500}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    page_width = page.execute_script("return document.documentElement.scrollWidth")
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    return page_width


def requests(page):
    """Return the addresses that the page asked for."""
    events = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    return [event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"]


def complaints(page):
    """Return what the console was told of errors and warnings."""
    return [entry for entry in page.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
