"""Every object that the API gives shows itself: in one line, as HTML in a notebook, and as a figure."""

import inspect
import io
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import sync_playwright

import helmbench
from helmbench import Record
from helmbench.api.diagnosis import Calibration
from helmbench.api.reproduction import Reproduction
from helmbench.bench.exam.scores import WorldScore, summary
from helmbench.diagnosis.calibration.result import Moved
from helmbench.diagnosis.result import Trace

from ..support.browser import chromium

PLAIN = {"Case", "RecordMeta"}
"""Facts that Python's own form shows."""
INDICES = {
    "length_m": 160.0,
    "speed_m_s": 7.7,
    "indices": [{"manoeuvre": "turn:35", "advance_m": 500.0, "tactical_diameter_m": 620.0, "speed_ratio": 0.6}],
}


@pytest.fixture(scope="module")
def records():
    return [helmbench.simulate("response-1", text, noise="low", seed=k)
            for k, text in enumerate(("zigzag:20/20", "zigzag:10/10:port"))]  # fmt: skip


@pytest.fixture(scope="module")
def results(board, tmp_path_factory):
    return helmbench.load_results(shutil.copytree(board, tmp_path_factory.mktemp("suite") / "out"))


@pytest.fixture(scope="module")
def raw_log(tmp_path_factory, records):
    path = tmp_path_factory.mktemp("log") / "raw.csv"
    helmbench.write_record(records[0], path)
    return path


@pytest.fixture(scope="module")
def logged(raw_log):
    return helmbench.import_log(raw_log)


def trace():
    time = np.arange(20.0)
    runs = [{"yaw_rate_rad_s": np.sin(time + shift)} for shift in (0.0, 0.1, 0.2)]
    return Trace("one", "train", time, np.zeros(20), *runs)


@pytest.fixture(scope="module")
def shown(records, results, raw_log, logged, craft):
    """Name of the class -> an object of it."""
    train, other = records
    estimate = helmbench.identify(train, "nomoto-1-cubic", "ls")
    biased = train.with_channels(yaw_rate_rad_s=train.column("yaw_rate_rad_s") + 0.005)
    facts = ("<me>", "world-1", "sensors", "alone", "wind", 1, True, 1.0, None, (), None, True, 0.5, 2.0)
    answer = WorldScore(*facts)
    row = {"paper": "003", "item": "table 5", "quantity": "<K>", "verdict": "agrees", "reason": "within 1 %"}
    return {
        "AdviceTest": helmbench.AdviceTest("# Advice\n\nIt is <good> in 3 of 4.\n", ({"regret": 1.0},), ()),
        "Assessment": estimate.assess(other),
        "ExamScores": helmbench.ExamScores(tuple(summary([answer])), (answer,)),
        "Changes": helmbench.compare_results(results.directory, results.directory),
        "Check": helmbench.check([biased, other]),
        "CraftDiagnosis": craft[2],
        "Comparison": helmbench.compare(train, "nomoto-1-cubic", ["ls", "rls"], validate=other),
        "Estimate": estimate,
        "Health": helmbench.doctor(),
        "Identifiability": estimate.identifiability(train),
        "Import": logged,
        "ImportDraft": helmbench.draft_import(raw_log),
        "Leaderboard": helmbench.leaderboard(results),
        "Model": helmbench.resolve("kvlcc2-l7"),
        "ModelFromIndices": helmbench.model_from_indices(INDICES),
        "Record": train,
        "Report": helmbench.write_report(results.directory),
        "Reproduction": Reproduction((row,), {"003": "1 claim"}, ()),
        "SimulatedRuns": helmbench.simulate_many("mariner", "zigzag:10/10", 3, indices=["first_overshoot"]),
        "SuiteResults": results,
        "Validation": helmbench.validate("response-1", records),
    }


def checked(thing):
    """Whether the line is short and tells the class, and the HTML is well formed and says something."""
    name = type(thing).__name__
    assert name == "Report" or (name in repr(thing) and len(repr(thing)) < 600)
    text = thing._repr_html_().replace("&nbsp;", " ").replace("<br>", "<br/>")
    tree = ElementTree.fromstring(f"<div>{text}</div>")
    assert len(" ".join(tree.itertext()).split()) > 2


def test_every_public_class_is_shown(shown):
    values = {name: getattr(helmbench, name) for name in helmbench.__all__}
    classes = {n for n, value in values.items() if inspect.isclass(value) and not issubclass(value, BaseException)}
    made = set(shown) | {"Diagnosis", "Calibration"}
    assert classes - PLAIN - made == set()


def test_each_shows_itself(shown):
    for thing in shown.values():
        checked(thing)


def test_a_diagnosis_and_a_calibration_show_themselves(diagnosis_of):
    checked(diagnosis_of())
    model = helmbench.resolve("kvlcc2-l7")
    moved = (Moved("R_0", "resistance", 0.02, 0.03, 0.025, 0.035, 50.0, 2.0),)
    nothing = dict.fromkeys(("steps", "remaining", "runs", "next_runs", "worse"), ())
    checked(Calibration(
        model=model, extended=model, calibrated=model, records=(("one", "train"),), verdict="named", moved=moved,
        reason="it does",
        before={}, after={}, shares={}, traces=(trace(),), wall_s=1.0, **nothing))  # fmt: skip


@pytest.mark.parametrize(
    "name",
    ["Assessment", "Check", "Comparison", "Estimate", "Identifiability", "Leaderboard", "Record", "Validation"],
)
def test_each_draws_itself(shown, records, name):
    thing = shown[name]
    figure = thing.plot(records[1]) if name == "Estimate" else thing.plot()
    assert figure.axes and any(axes.lines or axes.collections for axes in figure.axes)
    figure.savefig(io.BytesIO(), format="svg")


@pytest.mark.parametrize("name", ["Assessment", "Check", "Comparison", "Estimate", "Import", "Record", "Validation"])
def test_each_shows_its_figure_in_a_notebook_without_dead_buttons_or_literal_tags(shown, name):
    text = shown[name]._repr_html_()
    assert text.count("data:image/png;base64,") == 1
    assert "<button" not in text and "&lt;p&gt;" not in text and "&lt;table" not in text


def test_a_figure_shows_itself_in_a_notebook(records):
    assert records[0].plot()._repr_png_().startswith(b"\x89PNG")


def test_a_check_without_sizes_has_no_figure(records):
    found = helmbench.check(records)
    assert "<img" not in found._repr_html_()
    with pytest.raises(helmbench.BadInput, match="no finding"):
        found.plot()


def test_what_is_shown_is_escaped():
    text = Reproduction(({"paper": "1", "item": "2", "quantity": "<K>", "verdict": "", "reason": ""},), {}, ())
    assert "&lt;K&gt;" in text._repr_html_()


@pytest.mark.parametrize("name", ["_{}$^$", "$x", "a$b$c"])
def test_a_dollar_sign_in_a_name_is_no_formula(name, records):
    from dataclasses import replace

    record = replace(records[0], name=name)
    for figure in (record.plot(), helmbench.validate("response-1", record).plot()):
        file = io.BytesIO()
        figure.savefig(file, format="svg")
        assert file.getvalue()


# ---- Pictures of results in notebooks follow the notebook's theme.

THEMES = {
    "JupyterLab": ("<body data-jp-theme-light=false>", "<body data-jp-theme-light=true>"),
    "Visual Studio Code": ('<body class="vscode-dark">', '<body class="vscode-light">'),
    "Colab": ("<html theme=dark><body>", "<html><body>"),
}


@pytest.fixture(scope="module")
def tab():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox", "--disable-gpu"])
        yield browser.new_page()
        browser.close()


@pytest.mark.parametrize("shown", ["record", "figure"])
@pytest.mark.parametrize("theme", THEMES)
def test_pictures_are_dark_where_the_notebook_is(tab, theme, shown):
    record = Record([0.0, 1.0, 2.0], {"yaw_rate_rad_s": np.deg2rad([1.0, 2.0, 3.0])}, "run")
    html = (record if shown == "record" else record.plot())._repr_html_()
    dark, light = (_brightness(tab, f"<!doctype html>{body}{html}") for body in THEMES[theme])
    assert light > 200
    assert dark < 80


def _brightness(tab, page):
    """Mean of the light, 0 to 255, of the picture as it is drawn."""
    tab.set_content(page)
    drawn = tab.locator("img.helmbench").screenshot()
    return float(np.asarray(Image.open(io.BytesIO(drawn)).convert("L")).mean())
