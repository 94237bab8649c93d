"""A rudder that goes beyond the ship's stops holds another angle; one at its stops does not."""

import numpy as np
import pytest

import helmbench
from helmbench.estimation.rudder_scale import rudder_doubt


@pytest.fixture(scope="module")
def turn():
    return helmbench.simulate("kvlcc2-l7", "turn:35", duration_s=60.0, dt_s=0.5, noise="low", seed=1)


def with_rudder(record, factor):
    names = [n for n in ("rudder_rad", "rudder_command_rad") if record.has(n)]
    return record.with_channels(**{n: factor * record.column(n) for n in names})


@pytest.mark.parametrize("factor", [1.2, 2.0])
def test_a_rudder_beyond_the_stops_is_told(turn, factor):
    found = rudder_doubt([with_rudder(turn, factor)], helmbench.resolve("kvlcc2-l7"))
    assert found is not None and found.standing and found.cause == "wrong_unit"
    assert "stops of kvlcc2-l7 at 35 deg" in found.evidence and f"reaches {35 * factor:.2g}" in found.evidence


def test_a_rudder_at_its_stops_is_not(turn, rng):
    noisy = turn.with_channels(rudder_rad=turn.rudder() + np.deg2rad(1.0) + rng.normal(0.0, 0.005, turn.n))
    assert rudder_doubt([turn, noisy], helmbench.resolve("kvlcc2-l7")) is None


def test_a_model_without_stops_has_no_limit(turn):
    assert rudder_doubt([with_rudder(turn, 2.0)], helmbench.resolve("nomoto-1")) is None
