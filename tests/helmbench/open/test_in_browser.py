"""From a dropped log to the diagnosis in Chromium: by the page's own means, with hostile names, in both colours."""

import json

import numpy as np
import pandas as pd
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright
from scipy.signal import lfilter

from ...seeds import SHIFT
from ...support.browser import chromium
from .conftest import HOSTILE, TIME, swing

DROP = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name));
  document.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));
}"""
QUIET = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync"]
LONG_MS = 120_000
LOOKS = ((1280, "dark"), (390, "light"), *(((1280, "light"), (390, "dark")) if SHIFT else ()))
"""Widths and colours: all by `make test-all`."""
WORKING = """() => { const bar = document.querySelector("#job progress");
  return document.querySelector("#cancel") && bar && 0 <= bar.position && bar.position < 1 }"""
"""Whether the page shows at once how far a job is and a way to end it; a moment later the job may be done."""


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        yield playwright.chromium.launch(executable_path=chromium(), args=QUIET)


@pytest.fixture
def opened(site, browser):
    """Opens the page in a new tab: opened(); errors of its scripts and requests to elsewhere fail the test."""
    errors = []
    context = browser.new_context(
        viewport={"width": 1280, "height": 900}, accept_downloads=True, reduced_motion="reduce"
    )
    context.on("request", lambda call: None if _own(call.url, site) else errors.append(call.url))

    def build(work=""):
        tab = context.new_page()
        tab.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.on("dialog", lambda dialog: errors.append(dialog.message))
        tab.goto(site.link(work))
        return tab

    yield build
    context.close()
    assert errors == []


def _own(url, site):
    return url.startswith((f"{site.address}/", "data:", "blob:"))


def serious(tab):
    return [item["id"] for item in Axe().run(tab).response["violations"] if item["impact"] in ("serious", "critical")]


def test_from_a_dropped_log_to_the_diagnosis(opened, log):
    tab = opened()
    tab.wait_for_selector("#choose")
    assert "code" not in tab.url and tab.context.cookies() == []
    tab.evaluate(DROP, [f"{HOSTILE}{30 * 'log'}.csv", log.decode()])
    tab.wait_for_selector("#start", timeout=LONG_MS)
    names = tab.locator("li.column .name b").all_inner_texts()
    assert HOSTILE in names and len(names) == 10 and tab.locator("img").count() == 0

    # a range by dragging, then the parts
    before = tab.locator("ul.parts li").count()
    area = tab.locator("#parts .plot .u-over").first
    area.scroll_into_view_if_needed()
    box = area.bounding_box()
    tab.mouse.move(box["x"] + 0.1 * box["width"], box["y"] + 20)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 20, steps=4)
    tab.mouse.up()
    assert float(tab.input_value("#range-from")) == pytest.approx(40.0, abs=5.0)
    tab.click("#add-train")
    tab.wait_for_selector("text=to 240", timeout=LONG_MS)
    tab.fill("#range-from", "240.5")
    tab.fill("#range-to", "400")
    tab.locator("#add-held-out").press("Enter")
    tab.locator("ul.parts li.held_out", has_text="240.5 to 400").wait_for()
    assert before == tab.locator("ul.parts li").count() == 2

    # the question by keyboard, the stages, the answer
    tab.locator("#kind-check").focus()
    tab.keyboard.press("ArrowDown")
    tab.keyboard.press("ArrowDown")
    with tab.expect_response(lambda answer: "mariner" in (answer.request.post_data or "")):
        tab.select_option("#model", "mariner")
    tab.reload()  # loses no choice
    tab.wait_for_selector("#model")
    assert tab.is_checked("#kind-diagnose") and tab.input_value("#model") == "mariner"
    tab.locator("#start").press("Enter")
    tab.wait_for_function(WORKING)
    tab.wait_for_selector("#verdict", timeout=LONG_MS)
    told = tab.inner_text("#verdict .first")
    assert "yaw rate bias" in told
    assert tab.evaluate("document.activeElement.id") == "result-title"
    assert tab.locator("#result .plot canvas").count() >= 5 and tab.locator("#result svg.track path.curve").count() == 3
    assert tab.locator("#result math").count() > 3

    # plots move together
    tab.locator("#trace-in").press("Enter")
    lengths = tab.evaluate(
        "[...document.querySelectorAll('#result svg.track path.curve')].map(p => p.getAttribute('d').length)"
    )
    tab.locator("#trace-whole").press("Enter")
    whole = tab.evaluate(
        "[...document.querySelectorAll('#result svg.track path.curve')].map(p => p.getAttribute('d').length)"
    )
    assert all(part < 0.8 * all_ for part, all_ in zip(lengths, whole, strict=True))

    # files
    with tab.expect_download() as waiting:
        tab.get_by_role("button", name="The notebook that does the same").click()
    assert json.loads(waiting.value.path().read_text("utf-8"))["nbformat"] == 4
    with tab.context.expect_page() as waiting:
        tab.get_by_role("button", name="Report", exact=True).click()
    assert "yaw rate bias" in waiting.value.inner_text(".verdict")
    waiting.value.close()

    # a reload and another tab find everything; a new tab begins anew
    work = tab.url.partition("#")[2]
    tab.reload()
    tab.wait_for_selector("#verdict")
    assert tab.inner_text("#verdict .first") == told
    tab.close()
    fresh = opened()
    fresh.locator("#work summary").click()
    assert fresh.locator("#verdict").count() == 0 and fresh.url.partition("#")[2] != work
    with fresh.context.expect_page() as waiting:
        fresh.get_by_role("button", name="1 answer").first.click()
    waiting.value.wait_for_selector("#verdict")
    assert waiting.value.url.partition("#")[2] == work
    waiting.value.close()

    # both colours, desktop and phone
    again = opened(work)
    again.wait_for_selector("#verdict")
    for width, scheme in LOOKS:
        again.set_viewport_size({"width": width, "height": 844})
        again.emulate_media(color_scheme=scheme)
        assert again.evaluate("document.documentElement.scrollWidth") <= width
        assert serious(again) == []


@pytest.mark.nightly
def test_columns_without_names_are_confirmed_by_one_click_and_that_can_be_taken_back(opened):
    heading, rate, rudder = swing()
    rows = zip(TIME, heading, rate, rudder, strict=True)
    tab = opened()
    tab.wait_for_selector("#example")
    tab.evaluate(DROP, ["tank.dat", "\n".join(" ".join(f"{value:.5f}" for value in row) for row in rows)])
    tab.wait_for_selector("#questions", timeout=LONG_MS)
    assert tab.locator("#example").is_hidden()
    table = tab.locator("#questions table.proposal tbody tr")
    assert [row.split("\t")[1] for row in table.all_inner_texts()] == ["time", "heading", "yaw rate", "rudder"]
    assert tab.locator("#start").is_hidden() and serious(tab) == []
    tab.click("#question-0-answer-0")
    tab.wait_for_selector("#start", timeout=LONG_MS)
    assert tab.locator("#questions").count() == 0 and "480 rows, 2 Hz, none missing" in tab.inner_text("#columns")
    tab.locator("#pair summary").click()
    tab.wait_for_selector("#pair canvas")
    tab.locator("#answered summary").click()
    tab.get_by_role("button", name="take back").click()
    tab.wait_for_selector("#questions", timeout=LONG_MS)


@pytest.mark.nightly
def test_a_link_opens_one_tab_which_a_reload_keeps(site, browser):
    link = site.link()
    tab, other = browser.new_context().new_page(), browser.new_context().new_page()
    tab.goto(link)
    tab.wait_for_selector("#work li", state="attached")
    other.goto(link)
    other.get_by_role("alert").get_by_text("used already").wait_for()
    other.goto(f"{site.address}/#{tab.url.partition('#')[2]}")  # the address of the first tab, in another browser
    other.get_by_role("alert").get_by_text("Open the link that the terminal shows").wait_for()
    work = tab.url
    tab.reload()
    tab.wait_for_selector("#work li", state="attached")
    assert tab.url == work and tab.inner_text("#alert") == ""


@pytest.mark.nightly
def test_a_log_of_200_mb_is_read_and_drawn(opened, tmp_path):
    time = 0.1 * np.arange(2_600_000)
    rudder = 15.0 * np.sign(np.sin(time / 20.0) + np.sin(time / 33.0))
    rate = lfilter([0.01], [1.0, -0.99], 7.0 * rudder)  # deg/min, time constant 10 s
    columns = {
        "time [s]": time,
        "Heading [deg]": 180.0 + np.cumsum(rate) / 600.0,
        "ROT [deg/min]": rate,
        "Rudder [deg]": rudder,
    }
    spare = {f"Spare {k}": np.random.default_rng(k).normal(size=time.size) for k in range(8)}
    pd.DataFrame(columns | spare).to_parquet(tmp_path / "long.parquet", compression=None)
    assert (tmp_path / "long.parquet").stat().st_size > 200e6
    tab = opened()
    tab.set_input_files("#chooser", tmp_path / "long.parquet")
    tab.wait_for_selector("#start", timeout=LONG_MS)
    assert tab.locator("li.column").count() == 12
    assert float(tab.input_value("#range-to")) == pytest.approx(259_999.9, abs=1.0)
