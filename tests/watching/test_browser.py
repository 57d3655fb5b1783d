"""The page in a real browser, while a campaign runs."""

import threading
import time

import pytest
from report import soil

import graincal as gc
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store, holds_campaign

from .browser import Browser, until
from .conftest import Page

ROWS = "document.querySelectorAll('#evaluations tr:not(.waiting)').length"
DRAWN = "[...document.querySelectorAll('#figures figure')].filter((each) => each.querySelector('.plot .main-svg')).map((each) => each.id)"


def _slow(theta):
    time.sleep(0.03)
    return soil.respond(theta)


@pytest.fixture
def browser(tmp_path):
    browser = Browser(tmp_path / "profile")
    yield browser
    browser.close()


def test_the_page_grows_while_the_campaign_runs(browser, tmp_path):
    folder = tmp_path / "campaign"
    run = threading.Thread(
        target=lambda: gc.calibrate(
            gc.PythonModel(_slow), soil.reference(), soil.SPACE, method="iterative-bayesian", seed=3, alpha=20, stop=soil.STOP, workers=1, folder=folder
        ),
        daemon=True,
    )
    run.start()
    until(lambda: holds_campaign(folder) and Store.open(folder).last_iteration() is not None, bool)
    page = Page(folder)
    browser.call("Page.navigate", url=page.server.link)
    first = browser.until(ROWS)
    assert "running" in browser.until("document.getElementById('state').textContent", lambda text: "running" in text)
    assert browser.until(ROWS, lambda rows: rows > first) > first
    browser.until(DRAWN, lambda names: "latest" in names)
    browser.until("document.getElementById('state').textContent", lambda text: "finished" in text)
    run.join()
    assert set(browser.until(DRAWN, lambda names: {"responses", "convergence"} <= set(names))) <= {"responses", "latest", "convergence", "samples", "run_times"}
    browser.until("[...document.querySelectorAll('#facts dt')].map((each) => each.textContent)", lambda terms: "ended" in terms)
    kinds = ", ".join(f"{kind}: {number}" for kind, number in status(folder)["failure_kinds"].items())
    browser.until("document.getElementById('failures').textContent", lambda text: text == kinds)
    assert browser.said == []
    page.close()


def test_neither_the_token_nor_the_cookie_can_be_read_in_the_page_and_no_other_script_runs(browser, page):
    browser.call("Page.navigate", url=page.server.link)
    browser.until(DRAWN, lambda names: "latest" in names)
    assert browser.evaluate("document.cookie") == ""
    assert browser.evaluate("location.href") == f"http://127.0.0.1:{page.address[1]}/"
    assert browser.said == []
    browser.evaluate("document.body.append(Object.assign(document.createElement('script'), {textContent: 'window.ran = true'}))")
    assert browser.evaluate("window.ran === undefined")
    assert any("Content Security Policy" in each for each in browser.said)


@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_is_no_wider_than_the_window(width, browser, page):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=width < 500)
    browser.call("Page.navigate", url=page.server.link)
    browser.until(DRAWN, lambda names: {"responses", "convergence", "samples", "run_times"} <= set(names))
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert browser.evaluate("[...document.querySelectorAll('.plot')].every((each) => each.scrollWidth <= each.clientWidth)")
