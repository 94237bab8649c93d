"""The page of the leaderboard in a browser: what it computes, by keyboard, on a small screen, light and dark."""

import csv
import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

from helmbench.bench.store import Store, read_tables
from helmbench.reporting.leaderboard import page, publish
from helmbench.reporting.leaderboard.answer import answer, rivals
from helmbench.reporting.leaderboard.board import build

from ...support.browser import chromium

SELECTIONS = [
    ({}, math.inf),
    ({"noise": "medium"}, math.inf),
    ({"vessel": "mariner", "noise": "low"}, math.inf),
    ({"excitation": "zigzag 10/10"}, math.inf),
    ({}, 1.0),
    ({"vessel": "s175"}, 1.0),
]
BUDGETS = {1.0: "1 s"}
NAME = "recurrent,units=16,hidden=4,trials=8,window=100"
LONG = "heading:10deg/0.0105rad_s+4deg/0.031rad_s+2deg/0.083rad_s+1deg/0.166rad_s+zigzag:20/20"
"""Training records in a text that no blank divides."""


@pytest.fixture(scope="module")
def results(tmp_path_factory, made_up_results):
    folder = tmp_path_factory.mktemp("page") / "out"
    made_up_results(folder)
    page.write_report(folder)
    return folder


@pytest.fixture(scope="module")
def made_up_results():
    """Writes a store of eight methods, six vessels, two noises and excitations, three seeds."""
    from ...made_up.runs import make_parameter, make_run
    from ...seeds import seed_of

    rng = np.random.default_rng(seed_of("made-up results"))
    vessels, noises, trains = ("mariner", "s175", "cargo", "patrol", "remus", "kvlcc2-l7"), ("low", "medium"), (10, 20)
    methods = {
        "a": (1.0, 3.0),
        "b": (1.02, 0.4),
        "c": (1.3, 0.02),
        "d": (2.0, 0.01),
        "e": (6.0, 0.1),
        "lost": (9.0, 0.3),
        "mean": (1.9, 0.5),
    }

    def write(folder):
        runs = []
        for (m, (factor, wall)), v, n, t, s in product(methods.items(), vessels, noises, trains, range(3)):
            error = 0.02 * factor * float(np.exp(rng.normal(scale=0.1)))
            facts = {"method": m, "vessel": v, "noise": n, "seed": s, "train": f"zigzag:{t}/{t}", "cpu_s": wall}
            facts |= {"diverged": m == "lost" and (v == "remus" or s == 0)}
            parameters = [make_parameter("K", 1.0, 1.0 + error, 0.1)]
            run = make_run(error=error, r2=1.0 - error**2, parameters=parameters, **facts)
            trace = _trace(rng, error) | ({"log": _log(1.0 + error)} if m == "a" else {})
            runs.append(run | ({"trace": trace} if s == 0 else {}))
        runs.append(make_run(method="only-here", vessel="cargo", r2=0.9, train="zigzag:10/10", cpu_s=0.1))
        long = make_run(method="e", vessel="patrol", r2=0.9, train=LONG, cpu_s=0.1)
        runs.append(long | {"trace": _trace(rng, 0.1)})
        runs.append(make_run(method="c", vessel="s175", status="not_applicable", reason="no sway", train="turn:20"))
        manifest = {"suite": "made-up", "version": "0", "planned": len(runs), "seeds": "0-2", "title": "made up"}
        with Store.create(folder, manifest) as store:
            for run in runs:
                store.append(run)
            store.write_tables()

    return write


def _trace(rng, error):
    time = [float(i) for i in range(80)]
    measured = [math.sin(0.1 * t) for t in time]
    predicted = [value + error * float(rng.normal()) for value in measured]
    channels = {name: {"measured": measured, "predicted": predicted} for name in ("heading_rad", "yaw_rate_rad_s")}
    return {"record": "turn:35", "time_s": time, "channels": channels}


def _log(end):
    """A recursion that goes to `end`."""
    return {"time_s": [2.0 * i for i in range(40)], "values": {"K": [1e3, *(end - 1.0 / i for i in range(1, 40))]}}


@pytest.fixture(scope="module")
def browser():
    """Debian's Chromium; `make test` installs it."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        yield started
        started.close()


@pytest.fixture
def opened(browser, results):
    """Opens the page: opened(fragment, width, scheme); errors of its script fail the test."""
    contexts, errors = [], []

    def build(fragment="", width=1280, scheme="light"):
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, accept_downloads=True
        )
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.on("request", lambda call: errors.append(call.url) if not call.url.startswith(("file:", "blob:")) else None)
        tab.goto((results / "leaderboard.html").as_uri() + fragment)
        return tab

    yield build
    for context in contexts:
        context.close()
    assert errors == []


def board(results, chosen=None, budget=math.inf):
    """The contest of the chosen problems; a fit that takes longer than the budget has an infinite error."""
    found = build(*read_tables(results)).contest.where(chosen or {})
    late = found.times > budget
    runs = np.where(late[:, :, None] & ~np.isnan(found.runs), np.inf, found.runs)
    return replace(found, errors=np.where(late, np.inf, found.errors), runs=runs)


def choose(tab, chosen, budget):
    for name, text in chosen.items():
        tab.select_option(f"#choose-{name}", text)
    if budget in BUDGETS:
        tab.select_option("#choose-budget", BUDGETS[budget])


def ranking(tab):
    return [text.strip() for text in tab.locator("#ranking th[scope=row]").all_inner_texts()]


@pytest.mark.nightly
@pytest.mark.parametrize(("chosen", "budget"), SELECTIONS, ids=str)
def test_the_selector_ranks_and_answers_as_python_does(opened, results, chosen, budget):
    tab = opened()
    choose(tab, chosen, budget)
    expected = board(results, chosen, budget)
    places = expected.order()
    assert tab.inner_text("#answer") == answer(expected)
    assert ranking(tab) == [place.method for place in places]
    column = tab.locator("#ranking tbody tr:not(.rule) td:nth-child(3)").all_inner_texts()
    assert [float(text) for text in column] == pytest.approx([place.mean_rank for place in places], abs=0.0051)
    assert len(rivals(expected)) == tab.locator("#ranking tbody tr:not(.partial):not(.rule)").count() - 1


@pytest.mark.nightly
def test_what_was_not_run_cannot_be_chosen(opened):
    tab = opened()
    tab.select_option("#choose-excitation", "turn 20")
    disabled = tab.locator("#choose-vessel option:disabled").all_inner_texts()
    assert any("mariner" in text for text in disabled) and not any("s175)" in text for text in disabled)


@pytest.mark.nightly
def test_the_table_is_sorted_by_keyboard(opened):
    tab = opened()
    button = tab.locator("#ranking thead button", has_text="CPU time of a fit")
    button.focus()
    tab.keyboard.press("Enter")
    head = button.locator("xpath=..")
    assert head.get_attribute("aria-sort") == "ascending" and ranking(tab)[0] == "d"
    assert tab.evaluate("document.activeElement.textContent") == "CPU time of a fit"
    tab.keyboard.press("Space")
    assert head.get_attribute("aria-sort") == "descending" and ranking(tab)[0] == "a"
    assert tab.locator("#ranking th[aria-sort]").count() == 1
    other = tab.locator("details[open] thead button").first
    other.press("Enter")
    assert tab.locator("details[open] th[aria-sort=ascending]").count() == 1


@pytest.mark.nightly
def test_a_link_restores_the_selection(opened):
    tab = opened()
    choose(tab, {"vessel": "s175", "noise": "medium"}, 1.0)
    tab.locator("#ranking tbody button", has_text="b").first.click()
    fragment = tab.evaluate("location.hash")
    again = opened(fragment)
    assert again.inner_text("#answer") == tab.inner_text("#answer") and ranking(again) == ranking(tab)
    assert again.input_value("#choose-vessel") == "s175" and again.input_value("#choose-budget") == "1 s"
    assert again.inner_text("#run-title") == tab.inner_text("#run-title") == "Runs of b"
    assert opened("#vessel=unknown&_sort=none&_budget=x").locator("#ranking tbody tr").count() > 3


@pytest.mark.nightly
def test_a_run_shows_curves_residuals_and_estimates(opened):
    tab = opened()
    tab.locator("#ranking tbody button", has_text="e").first.click()
    titles = tab.locator("#run svg text.axis").all_text_contents()
    assert {"heading (deg)", "residual (deg)", "yaw rate (deg/s)", "time (s)"} <= set(titles)
    assert tab.locator("#run svg path.predicted").count() == 2 and tab.locator("#run table tbody tr").count() == 1
    problems = [text.partition(": error")[0] for text in tab.locator("#choose-problem option").all_inner_texts()]
    assert len(problems) == len(set(problems)) > 2


@pytest.mark.nightly
def test_a_recursion_shows_its_log_with_the_truth(opened):
    tab = opened()
    tab.locator("#ranking tbody button", has_text="a").first.click()  # a and b are so close that either may be first
    assert "Log of the recursion" in tab.locator("#run h3").all_inner_texts()
    assert tab.locator("#run .small svg").count() == 1
    assert "K (1/s)" in tab.locator("#run .small svg text.axis").all_text_contents()
    heights = [float(part.split()[-1]) for part in tab.locator("#run .small path.truth").get_attribute("d").split("L")]
    assert len(set(heights)) == 1 and 10.0 <= heights[0] <= 148.0
    drawn = tab.locator("#run .small path.predicted").get_attribute("d")
    assert all(10.0 <= float(part.split()[-1]) <= 148.0 for part in drawn.removeprefix("M").split("L"))
    tab.locator("#ranking tbody button", has_text="e").first.click()
    assert "Log of the recursion" not in tab.locator("#run h3").all_inner_texts()


@pytest.mark.nightly
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_nothing_overflows_and_axe_finds_nothing_serious(opened, width, scheme):
    tab = opened(width=width, scheme=scheme)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    tab.evaluate("name => document.querySelector('#answer b').textContent = name", NAME)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    found = [item for item in Axe().run(tab).response["violations"] if item["impact"] in ("serious", "critical")]
    assert found == []


@pytest.mark.nightly
@pytest.mark.parametrize("width", [1280, 390])
def test_a_run_with_a_long_name_overflows_no_screen_and_its_texts_are_legible(opened, results, width):
    problem = next(i for i, row in enumerate(board(results).problems.to_dict("records")) if row["train"] == LONG)
    tab = opened(f"#_method=e&_problem={problem}", width=width)
    assert LONG in tab.inner_text("#run .sub")
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    heights = tab.evaluate(
        "[...document.querySelectorAll('#run text, #front text')].map(t => t.getBoundingClientRect().height)"
    )
    turned = tab.evaluate(
        "[...document.querySelectorAll('#run text, #front text')].map(t => t.getBoundingClientRect().width)"
    )
    assert min(min(pair) for pair in zip(heights, turned, strict=True)) > 5.0 and min(heights) > 10.0


@pytest.mark.nightly
def test_csv_and_svg_are_downloaded(opened):
    tab = opened()
    with tab.expect_download() as waiting:
        tab.click("#csv")
    rows = list(csv.DictReader(waiting.value.path().read_text().splitlines()))
    assert [row["method"] for row in rows] == ranking(tab)
    with tab.expect_download() as waiting:
        tab.locator("#front .save").click()
    assert waiting.value.path().read_text().startswith("<svg")


@pytest.mark.nightly
def test_a_page_of_two_suites_begins_with_the_first(browser, results, tmp_path):
    """The choice of another suite, and of all of them, is kept in the address."""
    from ...made_up.runs import make_run

    facts = {"suite": "wind", "vessel": "esso-osaka-l3", "disturbance": "wind:8@40deg"}
    runs = [make_run(method=method, r2=r2, **facts) for method, r2 in (("a", 0.9), ("b", 0.8))]
    with Store.create(tmp_path / "wind", {"suite": "wind", "version": "0", "planned": 2}) as store:
        for run in runs:
            store.append(run)
        store.write_tables()
    publish.publish([results, tmp_path / "wind"], tmp_path / "published")
    tab = browser.new_page()
    tab.goto((tmp_path / "published" / publish.PAGE).as_uri())
    first, alone = tab.input_value("#choose-suite"), tab.inner_text("#basis")
    assert first == "made-up" and "suite" not in tab.url.partition("#")[2]
    for chosen in ("wind", ""):
        tab.select_option("#choose-suite", chosen)
        tab.reload()
        assert tab.input_value("#choose-suite") == chosen and tab.inner_text("#basis") != alone
    tab.get_by_role("button", name="Reset").click()
    assert tab.input_value("#choose-suite") == first and tab.inner_text("#basis") == alone
    tab.close()
