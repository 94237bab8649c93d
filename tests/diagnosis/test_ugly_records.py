"""Records with defects end in a verdict or in one clear line, and name no cause that is not there."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

import helmbench
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.innovations.searches import ByChangePoint, ByScore
from helmbench.diagnosis.options import Options
from helmbench.models.errors import CannotFit, FitFailed
from helmbench.models.model import resolve

from ..expectations.injections import passes

ZIGZAGS = ("zigzag:20/20", "zigzag:10/10")
FEW = Options(max_effects=1, alpha=1e-4)
"""False alarms one in 10,000: what a defect of the logger would bring is far beyond that."""


@pytest.fixture
def record(seed):
    return clean(seed)


def clean(seed):
    """A clean run of a fast first-order ship."""
    return generate(Case("response-1", "zigzag:20/20", "medium", seed=seed, duration_s=100.0, dt_s=0.5))


def rows(record, kept):
    return replace(record, time_s=record.time_s[kept], channels={k: v[kept] for k, v in record.channels.items()})


def times(record, factor, *names):
    return record.with_channels(**{name: factor * record.column(name) for name in names})


DEFECTS = {
    "rows missing for 60 s": lambda r: rows(r, np.r_[0:60, 180 : r.n]),
    "rows missing for 5 s": lambda r: rows(r, np.r_[0:60, 70 : r.n]),
    "yaw rate at every hundredth sample": lambda r: r.with_channels(
        yaw_rate_rad_s=np.where(np.arange(r.n) % 100, np.nan, r.column("yaw_rate_rad_s"))
    ),
    "heading jump": lambda r: r.with_channels(heading_rad=r.column("heading_rad") + 2.0 * (np.arange(r.n) > 90)),
    "twelve samples": lambda r: r.slice(0, 12),
    "no motion": lambda r: times(r, 1e-30, "heading_rad", "yaw_rate_rad_s"),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_nothing_is_named_for_a_defect_of_the_logger(seed, defect):
    own = itertools.count(seed)

    def quiet():
        found = diagnose(resolve("response-1"), [DEFECTS[defect](clean(next(own)))], options=FEW)
        json.dumps(found.to_json(), allow_nan=False)
        print(found.verdict, found.reason)
        return found.verdict in ("adequate", "inconclusive") and not found.causes

    assert passes(quiet, 0.99)


@pytest.mark.parametrize("samples", [2, pytest.param(3, marks=pytest.mark.nightly), 5])
def test_a_few_samples_are_told_as_no_manoeuvre(record, samples, tmp_path):
    short = replace(record.slice(0, samples), name="short"), replace(record.slice(100, 100 + samples), name="later")
    found = helmbench.diagnose("response-1", short[0], short[1])
    found.write(tmp_path / "out")
    assert found.verdict == "inconclusive" and "no manoeuvre" in found.reason and not found.causes
    assert all(np.isnan(gain.r2_before) or abs(gain.r2_before) < 1e9 for gain in found.gain.values())


def test_numbers_beyond_all_arithmetic_are_one_line(record):
    with pytest.raises((FitFailed, CannotFit)) as refused:
        diagnose(resolve("response-1"), [times(record, 1e200, "rudder_rad", "yaw_rate_rad_s")], options=FEW)
    assert "\n" not in str(refused.value)


def test_a_model_that_runs_away_is_told(record):
    model = resolve("response-1")
    with pytest.raises(FitFailed, match="response-1 cannot be run with the records"):
        diagnose(replace(model, coefficients=1e30 * model.coefficients), [record], options=FEW)


def test_a_second_order_model_whose_lead_nearly_cancels_is_diagnosed():
    model = resolve("cargo")
    values = model.parameters
    near = model.with_coefficients(model.from_parameters({**values, "T3": values["T1"] * (1.0 + 1e-7)}))
    record = generate(Case("cargo", "zigzag:20/20", "medium", duration_s=240.0, dt_s=2.0))
    found = diagnose(near, [record], options=FEW)
    json.dumps(found.to_json(), allow_nan=False)


def test_a_cause_whose_fit_fails_is_a_failed_candidate_with_its_reason(record, monkeypatch):
    def fail(*_):
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(ByChangePoint, "screen", fail)
    monkeypatch.setattr(ByScore, "refit", fail)
    exact = replace(FEW, coefficient_sd=0.0)
    found = diagnose(resolve("response-1"), [times(record, 1.3, "yaw_rate_rad_s")], options=exact)
    bank = {entry.cause: entry for entry in found.bank}
    assert bank["rudder_fault"].status == "not_testable"
    assert "SVD did not converge" in bank["rudder_fault"].why
    assert "SVD did not converge" in bank["yaw_rate_scale"].why


@pytest.fixture
def runs(seed):
    """Two clean zigzags of a fast first-order ship."""
    cases = [
        Case("response-1", text, "low", seed=seed + i, duration_s=200.0, dt_s=0.5) for i, text in enumerate(ZIGZAGS)
    ]
    return [generate(case) for case in cases]


@pytest.mark.parametrize("spoiled", [(0,), (0, 1)], ids=["one record", "all records"])
def test_rudder_and_heading_under_each_others_names_are_told(runs, spoiled):
    for i in spoiled:
        swap = {"rudder_rad": runs[i].column("heading_rad"), "heading_rad": runs[i].column("rudder_rad")}
        runs[i] = runs[i].with_channels(**swap)
    found = diagnose(resolve("response-1"), runs, options=Options(alpha=FEW.alpha))
    assert [f.cause for f in found.causes] == ["channel_swap"] and found.verdict == "named"
    assert "the yaw rate is that of the rudder column" in found.causes[0].evidence


def test_a_held_out_record_is_run_with_its_rudder_in_its_place(runs):
    """The heading under the rudder's name in all records: the base model has the error of the true columns."""
    swapped = [r.with_channels(rudder_rad=r.column("heading_rad"), heading_rad=r.column("rudder_rad")) for r in runs]
    told, true = (diagnose(resolve("response-1"), one[:1], one[1:], FEW).gain["heading_rad"] for one in (swapped, runs))
    assert told.rmse_before == pytest.approx(true.rmse_before)


def test_nothing_is_named_where_the_rudder_is_of_another_time(runs):
    """Two fifths of a record later: no phase of the zigzag is kept."""
    late = [r.with_channels(rudder_rad=np.roll(r.column("rudder_rad"), 2 * r.n // 5)) for r in runs]
    found = diagnose(resolve("response-1"), late)
    print(found.verdict, found.reason, found.causes)
    assert found.verdict not in ("named", "tied")
