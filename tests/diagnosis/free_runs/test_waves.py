"""Motion in waves, planted by the truth simulator: told alone, with its frequency, and apart from the errors."""

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.checks.check import check
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.one_bank.diagnose import runs_of
from helmbench.diagnosis.options import Options
from helmbench.models.coefficient_groups import values_of, with_values
from helmbench.models.model import resolve

OMEGA = 0.9
"""Peak frequency of the heading's motion, rad/s."""


def in_waves(heading_deg, rng, vessel="mariner"):
    """Records of a ship whose heading moves by so many degrees (rms)."""
    effect = Effect("wave_motion", {"rms": np.deg2rad(heading_deg), "omega": OMEGA, "damping": 0.1})
    return inject(FaultCase(vessel, effects=(effect,)), rng)


@pytest.mark.parametrize("heading_deg", [1.0, pytest.param(0.1, marks=pytest.mark.nightly)])
def test_waves_are_the_only_thing_that_is_told_of_a_right_model(heading_deg, rng):
    """The larger ones hide in the yaw acceleration what the rudder does."""
    case = in_waves(heading_deg, rng)
    said = diagnose(resolve("mariner"), case.train, case.held_out)
    assert (said.verdict, [f.cause for f in said.causes], said.remaining) == ("named", ["wave_motion"], ())
    sizes = {(s.parameter, s.record): s for s in said.causes[0].sizes}
    records = {record for _, record in sizes}
    assert records == {None, *(r.name for r in case.train)}
    period = sizes["period", None]
    assert period.value == pytest.approx(2.0 * np.pi / OMEGA, rel=0.1) and period.low < period.value < period.high
    assert sizes["heading_rms", None].value == pytest.approx(np.deg2rad(heading_deg), rel=0.35)
    assert said.causes[0].p_adjusted is None and not said.extends
    assert "period of" in said.causes[0].evidence


def test_errors_of_a_wrong_model_in_calm_water_are_no_waves(rng):
    ship, case = resolve("mariner"), inject(FaultCase("mariner"), rng)
    base = with_values(ship, {n: x * f for (n, x), f in zip(values_of(ship).items(), (1.15, 0.85) * 99, strict=False)})
    assert runs_of(base, case.train, Options()).waves == ()


def test_the_rudder_turns_the_ship_also_where_waves_make_most_of_her_yaw_acceleration(rng):
    case = in_waves(1.2, rng)
    said = [f.evidence for f in check([*case.train, *case.held_out]).findings]
    assert not [text for text in said if "it is not what turns the ship" in text]
