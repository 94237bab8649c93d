"""The verdict by precedence, its sentence, and what to run next."""

import numpy as np
import pytest

from helmbench.checks.result import Size
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.innovations import report
from helmbench.diagnosis.innovations.state import Candidate, Unmodelled
from helmbench.diagnosis.report import verdict
from helmbench.diagnosis.result import Finding, Trace
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve

OFFSET = Finding("rudder_offset", (), "dynamics", 90.0, 1e-9, (Size("delta0", 0.01, 0.008, 0.012, "rad"),))
TIED = Finding("current", ("wind",), "dynamics", 50.0, 1e-6, (), separate_by="runs on reciprocal courses")


def unknown(label="pulse in every record"):
    return Candidate(Unmodelled(label), (), 0.0, 0.0, None, None)


@pytest.mark.parametrize(
    ("poor", "left", "instead", "findings", "expected"),
    [
        ("no manoeuvre", unknown(), False, [OFFSET], "inconclusive"),
        (None, unknown(), False, [OFFSET], "unexplained"),
        (None, unknown(), True, [OFFSET], "unexplained"),
        (None, None, False, [OFFSET, TIED], "tied"),
        (None, None, False, [OFFSET], "named"),
        (None, None, False, [], "adequate"),
    ],
)
def test_precedence(poor, left, instead, findings, expected):
    assert report.decide(poor, left, instead, findings)[0] == expected


def test_the_sentence_says_why():
    plain = "the residuals are those of the model, its sensors' noise and zero-mean gusts"
    assert report.decide(None, None, False, [])[1] == plain
    assert report.decide(None, None, False, [OFFSET])[1] == f"with what is named, {plain}"
    assert report.decide(None, None, False, [TIED])[1] == "current cannot be told from wind"
    assert "pulse in every record" in report.decide(None, unknown(), False, [])[1]
    assert "as likely as all that is named" in report.decide(None, unknown(), True, [OFFSET])[1]


def test_what_to_run_next():
    assert "zigzag" in (verdict.next_manoeuvre("no manoeuvre", []) or "")
    assert verdict.next_manoeuvre(None, [OFFSET, TIED]) == "runs on reciprocal courses"
    assert verdict.next_manoeuvre(None, [OFFSET]) is None


@pytest.mark.parametrize(("manoeuvre", "decidable"), [("straight", False), ("zigzag:20/20", True)])
def test_a_record_without_a_manoeuvre_cannot_be_decided(manoeuvre, decidable):
    est = estimator(resolve("mariner"), [generate(Case("mariner", manoeuvre, "low", seed=1, duration_s=200.0))])
    said = report.undecidable(est, est.start())
    assert (said is None) == decidable
    assert decidable or "no manoeuvre" in said


def test_where_the_error_lies():
    """All of the error is put into turns to starboard with a large rudder angle, in the first half."""
    time = np.arange(100.0)
    rate, rudder = np.where(time < 50, 0.01, -0.01), np.where(time < 50, 0.3, 0.1)
    before = rate + np.where((time > 10) & (time < 40), 1e-3, 0.0)
    trace = Trace("a", "train", time, rudder, {"yaw_rate_rad_s": rate}, {"yaw_rate_rad_s": before}, {})
    found = {row["condition"]: row for row in verdict.where([trace])}
    shares = {condition: row["share_of_error"] for condition, row in found.items()}
    assert shares == pytest.approx(
        {
            "large rudder angles (above the median)": 1.0,
            "turns to starboard": 1.0,
            "the second half of a record": 0.0,
        }
    )
    assert all(0.4 < row["share_of_time"] < 0.6 for row in found.values())


@pytest.mark.parametrize(
    ("wrong", "share"), [(0.1, 0.99), (1.0, 0.0), (2.0, -3.0)], ids=["followed", "no motion", "other side"]
)
@pytest.mark.parametrize("channel", ["yaw_rate_rad_s", "heading_rad"])
def test_share_of_the_motion_that_free_runs_hold(channel, wrong, share, nan):
    """An error of a share of the motion; a heading counts about its mean, and unknown values do not count."""
    time = np.arange(200.0)
    motion = 0.2 * np.sin(2.0 * np.pi * time / 40.0)
    measured = motion + (3.0 if channel == "heading_rad" else 0.0)
    after = measured - wrong * motion
    after[::7] = nan
    trace = Trace("a", "train", time, 0.0 * time, {channel: measured}, {channel: after}, {channel: after})
    assert verdict.motion_explained([trace]) == pytest.approx(share, abs=0.02 * max(1.0, wrong**2))
    assert (verdict.without_motion([trace]) is None) == (share > 0.5)


def test_free_runs_of_held_out_records_do_not_decide_on_the_verdict():
    assert verdict.without_motion([]) is None
    rate = np.ones(10)
    trace = Trace("a", "held_out", rate, rate, {"yaw_rate_rad_s": rate}, {}, {"yaw_rate_rad_s": -rate})
    assert verdict.without_motion([trace]) is None
