"""Craft of measured sets without a model: what is predicted, and in which words it is said how far to trust."""

import re

import numpy as np
import pytest

from helmbench.datasets import measured
from helmbench.diagnosis.craft.build import build
from helmbench.diagnosis.craft.result import BUILT
from helmbench.estimation.validation.horizons import STRAIGHT
from helmbench.estimation.validation.validate import label
from helmbench.reporting import media
from helmbench.reporting.craft import page
from helmbench.reporting.diagnosis.measured import PUBLISHED
from helmbench.reporting.diagnosis.rivals import compared
from helmbench.reporting.validation.page import explained_lines

from ...nightly_marks import nightly_but


@pytest.fixture(scope="module", params=nightly_but(["craft-rov", "craft-expedition"], "craft-rov"))
def outcome(request, once):
    """(name, training records, held-out records, diagnosis) of a measured set."""
    report = PUBLISHED[request.param]
    if not (measured.data_dir() / report.dataset).is_dir():
        pytest.skip(f"no measured data in {measured.data_dir()}: set HELMBENCH_DATA")
    train, held_out = report.records()
    return request.param, train, held_out, once(request.param, lambda: build(train, held_out))


def test_the_model_is_not_worse_than_what_anyone_would_try_first(outcome):
    _, train, held_out, found = outcome
    scores = compared(found.model, train, held_out)
    assert scores.craft > max(scores.nomoto, scores.arx, 0.0) - 0.03 and scores.windows > 100


def test_it_is_said_how_far_to_trust_with_the_share_explained_and_the_floor(outcome):
    """The same sentence as of a diagnosis with a model: `explained_lines`."""
    name, _, _, found = outcome
    said = media.markdown(page(found), "title", "", {}).replace("\\", "")
    (line,) = (line for line in explained_lines(found.ahead) if line.startswith(f"{BUILT}: "))
    assert f"- {line}." in said.partition("## What to record next")[0]
    horizon = label(found.trusted_s if found.trusted_s > 0.0 else found.ahead.horizons_s[0])
    share, error, noise = re.search(
        rf"{re.escape(horizon)} ahead it explains (-?\d+) % of the yaw rate \(error (\S+), sensor noise (\S+) deg/s\)",
        line,
    ).groups()
    score = found.ahead.score("yaw_rate_rad_s", BUILT, horizon=horizon)
    assert int(share) == round(100.0 * score.r2)
    assert float(error) == pytest.approx(np.rad2deg(score.rmse), rel=0.01)
    assert float(noise) == pytest.approx(np.rad2deg(found.ahead.noise["yaw_rate_rad_s"]), rel=0.1)
    assert (found.trusted_s > 0.0) == (name == "craft-rov")


def test_in_waves_and_under_sail_the_yaw_rate_is_predicted_where_the_heading_is_not(outcome):
    name, _, _, found = outcome
    told = any("fitted to the yaw rate alone" in note for note in found.notes)
    assert told == (name == "craft-expedition")
    far = label(found.ahead.horizons_s[-1])
    straight = {s.channel: s.rmse for s in found.ahead.simple if (s.model, s.horizon) == (STRAIGHT, far)}
    assert found.ahead.score("yaw_rate_rad_s", BUILT, horizon=far).rmse < 0.9 * straight["yaw_rate_rad_s"]
    if told:
        assert found.ahead.score("heading_rad", BUILT, horizon=far).rmse > straight["heading_rad"]
