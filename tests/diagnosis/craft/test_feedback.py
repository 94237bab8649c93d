"""A controller that steers is told, however often its reference changes; manoeuvres and what they cause are none."""

import numpy as np
import pandas as pd
import pytest

from helmbench.datasets.record import Record
from helmbench.diagnosis.craft.build import build
from helmbench.diagnosis.craft.records import FED_BACK, feedback_share
from helmbench.diagnosis.craft.windows import pieces_of, scales_of
from helmbench.reporting import media
from helmbench.reporting.craft import page

from ...simulators.craft import LAWS, draw, sailed

DT, STEP_S, GAINS, LIMIT = 0.1, 8.0, (1.5, 1.0), 0.6


def steered(rng, order, count=3000, time_s=1.5, sea=0.1):
    """A record of a first-order craft in waves, r' = (d - r)/T, whose rudder, 2 rad/s fast, follows
    order(k, heading, yaw_rate)."""
    heading = rate = acting = push = 0.0
    rows = np.empty((count, 3))
    for k in range(count):
        seen = np.array([heading, rate]) + 0.005 * rng.standard_normal(2)
        command = order(k, *seen)
        rows[k] = command, *seen
        acting += np.clip(command - acting, -2.0 * DT, 2.0 * DT)
        push += -push * DT / (2.0 * time_s) + sea * np.sqrt(DT) * rng.standard_normal()
        rate += DT * (acting - rate + push) / time_s
        heading += DT * rate
    columns = dict(zip(("rudder_rad", "heading_rad", "yaw_rate_rad_s"), rows.T, strict=True))
    return Record.from_dataframe(pd.DataFrame({"time_s": DT * np.arange(count), **columns}), "run")


def controlled(rng, **options):
    """The record of a controller of heading and yaw rate whose reference steps every STEP_S."""
    reference = np.cumsum(rng.uniform(-1.0, 1.0, 400))

    def order(k, heading, yaw_rate):
        error = reference[int(k * DT / STEP_S)] - heading
        return np.clip(GAINS[0] * error - GAINS[1] * yaw_rate, -LIMIT, LIMIT)

    return steered(rng, order, **options)


def zigzagged(rng):
    """The record of zigzags of 0.4 rad by 0.35."""
    side = [1.0]

    def order(k, heading, yaw_rate):
        if side[0] * heading > 0.35:
            side[0] = -side[0]
        return 0.4 * side[0]

    return steered(rng, order)


def fed_back(record):
    """The share of the feedback in a record."""
    scales = scales_of([record])
    return feedback_share(pieces_of([record], scales), scales.time_s)


@pytest.mark.parametrize("sea", [0.0, 0.1])
def test_a_controller_whose_reference_steps_is_told(sea, rng):
    assert FED_BACK < fed_back(controlled(rng, sea=sea)) < 1.0


@pytest.mark.parametrize("law", LAWS)
def test_no_controller_is_told_of_commands_that_step(law, rng):
    assert fed_back(sailed(rng, draw(rng, law), "run")) < 0.5


def test_a_zigzag_is_no_controller(rng):
    assert fed_back(zigzagged(rng)) == 0.0


@pytest.mark.nightly
def test_what_is_found_beside_a_controller_is_not_said_of_the_craft_alone(rng):
    outcome = build([controlled(rng, sea=0.1) for _ in range(2)])
    said = media.markdown(page(outcome), "title", "", {})
    assert "a controller steers" in outcome.doubts[0] and "It lacks" not in said
