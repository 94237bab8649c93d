"""Paper 002: the noise on the right side, the printed maps, the step beta, and what the tank test may show."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.journal import read_runs
from helmbench.datasets.measured import data_dir
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, simulate
from helmbench.reproduction import runner
from helmbench.reproduction.claims import files
from helmbench.reproduction.papers.paper_002 import studies
from helmbench.reproduction.verdicts import spread, within

from .named import drawn


def have_data() -> bool:
    return (data_dir() / "kvlcc2" / "hsva").is_dir()


@pytest.fixture(scope="module")
def paper():
    return files.load("002")


@pytest.fixture(scope="module")
def found():
    """One run of every study that needs no measured data, the tank test where they are there."""
    chosen = {name: study for name, study in studies.STUDIES.items() if name != "tank" or have_data()}
    return {name: study.function(np.random.default_rng(0), index=0) for name, study in chosen.items()}


@pytest.mark.nightly
def test_every_key_is_computed(paper, found):
    entries = [(c.study, key) for c in paper.claims for key in (c.corrected, c.as_printed) if key]
    entries += [(check.study, check.key) for check in paper.checks()]
    assert [e for e in entries if e[0] in found and e[1] not in found[e[0]].values] == []


@pytest.mark.nightly
def test_independent_values_are_reached(paper, found):
    checks = [check for check in paper.checks() if check.study in found]
    assert [c.id for c in checks if not within(c, spread([found[c.study].values[c.key]]))] == []


@pytest.mark.parametrize("name", ["response-1", "response-2"])
def test_noise_forces_the_right_side(name):
    """A constant e on the right side, small: r settles at e, and the impulse of the first step is T3-free."""
    model, e = replace(resolve(name), max_step_s=0.1), 1e-5
    extra = studies._as_rudder(model, np.full(4000, e))
    state = initial_state(model)
    for angle in extra[:2000]:
        state = simulate(model, [[angle]] * 2, studies.STEP_S, state, hold="zero")[1]
    assert state[model.states.index("r")] == pytest.approx(e, rel=1e-3)
    gain, lead = model.parameters["K"], model.parameters.get("T3", 0.0)
    impulse = lead * np.diff(extra) + studies.STEP_S * extra[1:]
    assert gain * impulse == pytest.approx(np.full(3999, studies.STEP_S * e), rel=1e-9)


def test_printed_maps():
    p = {"T": 10.0, "K": 0.2, "alpha": 250.0}
    assert studies.printed_first(p) == pytest.approx({"T": 0.1, "K": 0.002, "alpha": 2.5})
    assert studies.printed_second({"h": 8.0, "alpha": 98.0}) == pytest.approx({"h": 8.0, "alpha": 0.98})


@pytest.mark.nightly
def test_the_iteration_is_worse_than_what_it_iterates(found):
    """Order of the methods in noise: basic, with repeats, with repeats and beta."""
    series = found["noise"].series
    assert np.median(series["basic"]) < np.median(series["without"]) < np.median(series["fci.printed"])


def test_the_tank_test_needs_its_data(monkeypatch, tmp_path):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    with pytest.raises(BadInput, match="helmbench fetch kvlcc2-hsva"):
        studies.tank(np.random.default_rng(0), index=0)


@pytest.mark.nightly
def test_the_tank_test_keeps_no_measured_series(found):
    if "tank" not in found:
        pytest.skip("no measured data: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")
    series = found["tank"].series
    assert {name for name in series if not name.startswith("r2.")} == {"time_s", "course.K", "course.T", "course.alpha"}
    assert np.diff(series["time_s"]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.nightly
def test_figures_are_drawn(found):
    sizes = drawn("002", found)
    assert min(sizes.values()) > 1000 and max(sizes.values()) < 200_000


def test_without_the_measured_set_the_stored_run_stands(monkeypatch, tmp_path):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    stored = runner.execute(runner.StudyJob("002", "tank", 0))
    assert stored["row"]["error"] is None and stored["series"]
    keys = {c.corrected for c in files.load("002").claims if c.study == "tank"}
    assert keys and keys <= set(runner.result_of(stored).values)


@pytest.mark.nightly
@pytest.mark.skipif(not have_data(), reason="the measured set is not there")
def test_the_stored_run_is_what_the_measured_set_gives(found):
    (stored,) = read_runs(runner.STORED)
    scores = {key: value for key, value in runner.result_of(stored).values.items() if np.isfinite(value)}
    assert {key: found["tank"].values[key] for key in scores} == pytest.approx(scores, rel=1e-3, abs=1e-3)
