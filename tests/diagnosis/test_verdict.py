"""The verdict by precedence, its sentence, and what to run next."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis import verdict
from helmbench.diagnosis.result import Finding, Size, Trace
from helmbench.diagnosis.state import Candidate, Unmodelled
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
    assert verdict.decide(poor, left, instead, findings)[0] == expected


def test_the_sentence_holds_the_size_or_the_rivals():
    said = verdict.decide(None, None, False, [OFFSET])[1]
    assert said == "rudder_offset (delta0 = 0.01 rad, 90 % interval 0.008 to 0.012)"
    assert verdict.decide(None, None, False, [TIED])[1] == "current cannot be told from wind"
    assert "pulse in every record" in verdict.decide(None, unknown(), False, [])[1]
    assert "as likely as all that is named" in verdict.decide(None, unknown(), True, [OFFSET])[1]


def test_what_to_run_next():
    assert "zigzag" in (verdict.next_manoeuvre("no manoeuvre", []) or "")
    assert verdict.next_manoeuvre(None, [OFFSET, TIED]) == "runs on reciprocal courses"
    assert verdict.next_manoeuvre(None, [OFFSET]) is None


@pytest.mark.parametrize(("manoeuvre", "decidable"), [("straight", False), ("zigzag:20/20", True)])
def test_a_record_without_a_manoeuvre_cannot_be_decided(manoeuvre, decidable):
    est = estimator(resolve("mariner"), [generate(Case("mariner", manoeuvre, "low", seed=1, duration_s=200.0))])
    said = verdict.undecidable(est, est.start())
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
