"""`helmbench diagnose`: its command, files, page and words, on a diagnosis made by hand (no engine)."""

import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from helmbench.api.diagnosis import FILES
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import write_record
from helmbench.diagnosis import diagnose as engine
from helmbench.diagnosis.result import Size
from helmbench.models.extend import extended
from helmbench.models.model import model_to_json, resolve
from helmbench.reporting.diagnosis import text as words
from helmbench.reporting.diagnosis.markdown import banded, correlation, figures, write_markdown
from helmbench.reporting.diagnosis.page import html, residual
from helmbench.reporting.equations import equations
from helmbench.reporting.traces import nice, thinned

from ...made_up_diagnosis import made_up


@pytest.fixture(scope="module")
def found():
    return made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, {"yaw_rate_bias": 0.002})


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    for name, manoeuvre in (("train", "zigzag:20/20"), ("other", "zigzag:10/10:port")):
        write_record(generate(Case("response-1", manoeuvre, "low")), folder / f"{name}.csv")
    return folder


@pytest.fixture
def asked(found, monkeypatch):
    """What the command asked of the engine, which answers with the diagnosis made by hand."""
    calls = []

    def answer(model, train, held_out, options):
        calls.append((model, train, held_out, options))
        roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
        return replace(found, records=tuple(roles))

    monkeypatch.setattr(engine, "diagnose", answer)
    return calls


def test_the_command_parses_calls_and_writes_three_files(files, asked, tmp_path, capsys):
    arguments = ["diagnose", "--model", "response-1", "--train", files / "train.csv", "--held-out", files / "other.csv"]
    arguments += ["--channels", "heading,yaw_rate", "--alpha", "0.05", "--max-effects", "2", "--seed", "7"]
    arguments += ["--base-parameters", "file", "--coefficient-sd", "0.1", "-o", tmp_path / "out"]
    assert status_of([str(a) for a in arguments]) == 0
    out, err = capsys.readouterr()
    ((model, train, held_out, options),) = asked
    assert (model.id, [r.name for r in train], [r.name for r in held_out]) == ("response-1", ["train"], ["other"])
    assert options == engine.Options("file", 0.1, ("heading_rad", "yaw_rate_rad_s"), 2, 0.05, 7)
    assert out.startswith("named: The simulation misses rudder offset (rudder_offset 1.15 deg [1.03, 1.26])")
    assert "RMSE before" in out and "diagnosis.html" in err
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(FILES)
    document = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert document["schema"] == 1 and document["verdict"] == "named"
    assert document["records"] == [
        {"file": str(files / "train.csv"), "role": "train"}, {"file": str(files / "other.csv"), "role": "held_out"},
    ]  # fmt: skip
    model = resolve(tmp_path / "out" / "extended_model.json")
    assert model.parameters["rudder_offset"] == 0.02 and model.instruments == {"yaw_rate_bias": 0.002}


def test_json_and_quiet(files, asked, tmp_path, capsys):
    arguments = ["diagnose", "--model", "response-1", "--train", str(files / "train.csv"), "-o", str(tmp_path / "out")]
    assert status_of([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["causes"][0]["cause"] == "rudder_offset"
    assert status_of([*arguments, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


BAD = {
    "no such file": (["--model", "response-1", "--train", "{0}/none.csv"], "none.csv"),
    "both sides": (["--model", "response-1", "--train", "{0}/train.csv", "--held-out", "{0}/train.csv"], "held out"),
    "unknown model": (["--model", "nothing", "--train", "{0}/train.csv"], "nothing"),
    "unknown extension": (["--model", "nomoto-1+wings", "--train", "{0}/train.csv"], "wings"),
    "nothing known": (["--model", "nomoto-1", "--train", "{0}/train.csv", "--base-parameters", "file"], "coefficients"),
    "unknown channel": (["--model", "response-1", "--train", "{0}/train.csv", "--channels", "draught"], "draught"),
    "alpha": (["--model", "response-1", "--train", "{0}/train.csv", "--alpha", "2"], "alpha"),
    "no record": (["--model", "response-1"], "--train"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_writes_nothing(case, files, asked, tmp_path, capsys):
    arguments, told = BAD[case]
    assert status_of(["diagnose", *[a.format(files) for a in arguments], "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and told in err
    assert list(tmp_path.iterdir()) == []


def test_a_target_that_cannot_be_is_refused_before_anything_is_computed(files, asked, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    for target in (tmp_path / "taken", tmp_path / "none" / "out"):
        arguments = ["diagnose", "--model", "response-1", "--train", str(files / "train.csv"), "-o", str(target)]
        assert status_of(arguments) == 2 and capsys.readouterr().err.count("\n") == 1
    assert asked == []


def test_the_page_is_one_file_that_argues_in_order(found):
    page = html(found)
    heads = re.findall(r"<h2>(.*?)</h2>", page)
    assert [head[:2] for head in heads[:5]] == ["1.", "2.", "3.", "4.", "5."]
    assert page.index(words.verdict(found).split(".")[0]) < page.index("<h2>")
    assert not re.findall(r"""(?:src|href)\s*=|url\(|@import""", page)
    assert page.count("<svg") >= 8 and not any("nan" in path for path in re.findall(r' d="(.*?)"', page))
    for svg in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        ElementTree.fromstring(svg)
    for math in re.findall(r"<math>.*?</math>", page, re.DOTALL):
        ElementTree.fromstring(math)


@pytest.mark.parametrize("verdict", ["adequate", "inconclusive", "unexplained", "tied"])
def test_every_verdict_has_its_page(verdict, found):
    other = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, verdict=verdict, held=0)
    page = html(other)
    assert "the gain was not measured" in page and words.verdict(other).split(":")[0][:40] in page
    assert ("The model stays as it is" in page) == (verdict != "tied")
    assert words.terminal(other).startswith(verdict)


def test_names_in_the_page_are_escaped(found):
    page = html(replace(found, reason="<script>alert(1)</script>", records=(("<b>.csv", "train"),)))
    assert "<script>" not in page and "&lt;b&gt;.csv" in page


def test_a_diverged_run_does_not_hide_the_measured_one(found):
    trace = found.traces[-1]
    wild = np.exp(0.2 * trace.time)
    wild[-10:] = np.inf
    page = html(replace(found, traces=(replace(trace, before={**trace.before, "yaw_rate_rad_s": wild}),)))
    ticks = [float(t) for t in re.findall(r'text-anchor="end" fill="#5b6b7b">(-?[\d.e+]+)</text>', page)]
    assert max(map(abs, ticks)) < 1e5


def test_markdown_carries_statistics_and_no_series(found, tmp_path):
    paths = write_markdown(found, tmp_path, "made-up", "Made up")
    assert {p.name for p in paths} == {"made-up.md", *(f"made-up-{name}.svg" for name in figures(found))}
    text = paths[0].read_text()
    assert "| RMSE before |" in text and "$$" in text and "![" in text
    longest = max(len(re.findall(r"[ML]", d)) for p in paths[1:] for d in re.findall(r' d="(.*?)"', p.read_text()))
    assert longest <= 20 and len(text) < 20_000
    for path in paths[1:]:
        ElementTree.parse(path)


def test_the_spectrum_finds_a_sine_where_it_is(rng):
    time = 0.5 * np.arange(2000)
    error = 0.3 * np.sin(2 * np.pi * 0.1 * time) + 0.01 * rng.normal(size=time.size)
    edges = np.geomspace(0.004, 1.0, 15)
    level = banded(time, error, edges)
    assert edges[np.nanargmax(level)] <= 0.1 <= edges[np.nanargmax(level) + 1]
    assert correlation(time, error, 10.0) > 0.95 and correlation(time, rng.normal(size=2000), 10.0) < 0.15


@pytest.mark.parametrize(
    ("item", "told"),
    [
        (Size("delta0", 0.01, 0.009, 0.011, "rad"), "delta0 0.573 deg [0.516, 0.63]"),
        (Size("e", -0.2, -0.25, -0.15, "1"), "e −20 % [−25, −15]"),
        (Size("Nrr", -0.003, -0.0030021, -0.0029979, "1"), "Nrr −0.003 [−0.0030021, −0.0029979]"),
        (Size("speed", 0.2, 0.1, 0.3, "m/s", "run_1"), "speed 0.2 m/s [0.1, 0.3] in run_1"),
        (Size("t0", 100.0, float("nan"), float("nan"), "s"), "t0 100 s [–, –]"),
    ],
)
def test_sizes_are_told_in_units_that_people_use(item, told):
    assert words.size(item) == told


def lines(vessel, *extensions, **instruments):
    base = resolve(vessel)
    model = base
    for name in extensions:
        model = extended(model, name)
    return equations(replace(model, instruments=instruments), base)


def test_an_added_term_is_marked_in_its_equation_alone():
    told = lines("mariner", "yaw_damping_quadratic")
    assert [line.new for line in told.dynamics] == [False, False, True, False, False, False]
    (marked,) = re.findall(r"<span class='term new'>(.*?)</span>$", told.dynamics[2].html.split("\n")[-1])
    assert "N′" in marked and "underbrace" in told.dynamics[2].latex
    assert "Xvvu" not in told.dynamics[0].html and [row[2] for row in told.added] == ["added_Nr_absr"]


def test_rudder_and_sensors_are_told_as_relations():
    told = lines("mariner", "rudder_offset", rudder_delay=1.0, yaw_rate_bias=0.01)
    assert told.relations[0].latex == r"\delta_{\mathrm{hull}} = \delta\left(t - \tau_{\delta}\right) + \delta_{0}"
    assert len(told.relations) == 2 and not any(line.new for line in told.dynamics)
    assert "hull" in told.dynamics[1].latex


def test_a_new_state_is_a_new_equation():
    told = lines("response-1", "second_order_lead")
    assert told.dynamics[-1].new and told.dynamics[-1].latex.startswith(r"\dot{z} =")


def test_axes_and_thinning():
    assert nice(0.0, 10.0, 4) == [0.0, 2.5, 5.0, 7.5, 10.0] and nice(-1.2, 1.3, 4)[0] == -1.0
    time, values = np.arange(10_000.0), np.zeros(10_000)
    values[5003] = 7.0
    x, y = thinned(time, values)
    assert x.size < 1000 and y.max() == 7.0 and x[0] == 0.0


def test_headings_are_compared_the_short_way_round(found):
    trace = found.traces[0]
    turned = replace(trace, before={**trace.before, "heading_rad": trace.before["heading_rad"] + 4 * np.pi})
    np.testing.assert_allclose(
        residual(turned, "heading_rad", "before"), residual(trace, "heading_rad", "before"), atol=1e-12
    )


def test_simulate_identify_and_diagnose_take_an_extended_model(tmp_path, capsys):
    """The chain with the engine: a record that an extended model wrote holds nothing that this model lacks."""
    truth = replace(
        extended(resolve("response-1"), "rudder_offset", {"rudder_offset": 0.02}),
        instruments={"yaw_rate_bias": 0.002, "rudder_delay": 1.0},
    )
    model_to_json(truth, tmp_path / "truth.json")

    def call(*arguments):
        assert status_of([str(a) for a in arguments]) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    for seed, manoeuvre in enumerate(("zigzag:20/20", "sine:20deg/90s", "zigzag:10/10")):
        out = ["-o", tmp_path / f"{seed}.csv", "--seed", seed, "--quiet"]
        duration = ["--duration", 300, "--dt", 0.5, "--noise", "low"]
        call("simulate", tmp_path / "truth.json", "--manoeuvre", manoeuvre, *duration, *out)
    records = [tmp_path / f"{seed}.csv" for seed in range(3)]
    given = ["--model", tmp_path / "truth.json", "--method", "output-error", "-o", tmp_path / "fit.json"]
    told = json.loads(call("identify", *records[:2], *given, "--validate", records[2], "--json"))
    fitted = {entry["parameter"]: entry["estimate"] for entry in told["parameters"]}
    assert fitted["rudder_offset"] == pytest.approx(0.02, rel=0.05)
    assert fitted["K"] == pytest.approx(truth.parameters["K"], rel=0.02)
    assert told["validation"]["r2_free_heading_rad"] > 0.999
    assert resolve(tmp_path / "fit.json").instruments == truth.instruments
    given = ["--train", *records[:2], "--held-out", records[2], "-o", tmp_path / "out", "--json"]
    told = json.loads(call("diagnose", "--model", tmp_path / "truth.json", *given))
    assert told["verdict"] == "adequate" and told["causes"] == []
    call("simulate", tmp_path / "out" / "extended_model.json", "--manoeuvre", "zigzag:20/20", *duration, *out)
