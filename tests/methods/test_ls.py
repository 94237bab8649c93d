"""Batch least squares: exact on its own difference equation, the published numbers on measured records."""

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.methods.ls import Ls, LsForward
from helmbench.models.errors import BadInput
from helmbench.models.model import list_vessels, resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

from ..made_up.records import driven, relative_errors
from ..simulators.paper_000 import difference_record, in_paper_order


@pytest.mark.parametrize("vessel", list_vessels())
def test_exact_on_its_own_difference_equation(suite, vessel):
    model, records = suite(vessel, euler=True)
    estimate = LsForward().fit(records, model.blanked())
    worst = max(relative_errors(estimate, model).items(), key=lambda item: item[1])
    assert worst[1] < 1e-6, worst
    zeros = [name for name, value in model.parameters.items() if not value]
    assert all(abs(estimate.parameters[name]) < 1e-7 for name in zeros)


def test_first_order_on_hsva(hsva):
    """Train on 15/5 at the measured 0.05 s, and at 0.5 s: K, T and alpha of the literature, to 1 %."""
    record, model = hsva("Z_15_05"), resolve("nomoto-1-cubic")
    fine = LsForward().fit([record], model).parameters
    assert [fine[k] for k in ("K", "T", "alpha")] == pytest.approx([0.3239, 20.12, 213.0], rel=1e-3)
    tenth = Record(record.time_s[::10], {k: v[::10] for k, v in record.channels.items()}, "0.5 s", record.meta)
    coarse = LsForward().fit([tenth], model).parameters
    assert [coarse[k] for k in ("K", "T", "alpha")] == pytest.approx([0.4183, 26.31, 594.5], rel=1e-3)


@pytest.mark.parametrize(
    ("vessel", "expected"),
    [
        ("response-1", {"K": 0.21599763, "T": 13.56734557, "alpha": 258.34238}),
        ("response-2", {"h": 8.88853422, "g": 16.24021654, "alpha": 98.32122369, "T3": 0.36399628, "K": 0.20100179}),
    ],
)
def test_noise_free_zigzag_of_paper_002(vessel, expected):
    """Forward differences of a continuous 5/10 zigzag, dt 0.1 s, 200 s: the known errors of the scheme."""
    model = resolve(vessel)
    found = LsForward().fit([_zigzag(model, 5.0, 10.0, 200.0)], model).parameters
    assert found == pytest.approx(expected, rel=1e-4)


def _zigzag(model, rudder_deg, heading_deg, duration, dt=0.1):
    """A 5/10 zigzag whose rudder changes instantly and is held between samples."""
    angle, heading = np.deg2rad([rudder_deg, heading_deg])
    rudder, state, order = [0.0], initial_state(model), angle
    states = [state]
    i_psi = model.states.index("psi")
    for _ in range(round(duration / dt)):
        if order * state[i_psi] > 0.0 and abs(state[i_psi]) >= heading:
            order = -order
        rudder[-1] = order
        state = simulate(model, inputs_of(model, [order, order]), dt, state)[1]
        states.append(state)
        rudder.append(order)
    rate = np.array(states)[:, model.states.index("r")]
    return Record(dt * np.arange(len(rudder)), {"rudder_rad": np.array(rudder), "yaw_rate_rad_s": rate}, "5/10")


def test_difference_equation_of_paper_000():
    estimate = Ls("heading-difference").fit([difference_record()], resolve("kt"))
    assert in_paper_order(estimate.parameters) == pytest.approx([2.9686, 2.2256, 2.2071, 2.2309], rel=1e-12)


def test_standard_errors_are_those_of_repetition(rng):
    """Equation noise on an Euler record: the spread over 200 repetitions is the stated standard error."""
    model, dt = resolve("response-1"), 0.2
    rudder = 0.3 * np.sign(np.sin(np.arange(600) * 0.05))
    found, stated = [], []
    for _ in range(200):
        r, psi = np.zeros((2, rudder.size))
        kick = 1e-4 * rng.normal(size=rudder.size)
        a, b, c = model.coefficients
        for k in range(rudder.size - 1):
            r[k + 1] = r[k] + dt * (a * r[k] + b * rudder[k] + c * r[k] ** 3 + kick[k])
            psi[k + 1] = psi[k] + dt * r[k]
        record = Record(dt * np.arange(rudder.size), {"rudder_rad": rudder, "yaw_rate_rad_s": r, "heading_rad": psi})
        estimate = LsForward().fit([record], model)
        found.append(list(estimate.parameters.values()))
        stated.append(list(estimate.stderr.values()))
    ratio = np.std(found, axis=0) / np.mean(stated, axis=0)
    assert np.all((ratio > 0.8) & (ratio < 1.25)), ratio


def test_undetermined_coefficients_have_infinite_errors():
    model = resolve("kvlcc2-l7")
    record = driven(model, np.zeros(400), 0.2)
    estimate = Ls().fit([record], model)
    assert np.isfinite(estimate.coefficients).all()
    assert estimate.stderr["N_rrr"] == np.inf
    assert estimate.extra["rank"] < len(model.coordinates)
    assert "determine" in estimate.message


def test_unknown_scheme():
    with pytest.raises(BadInput, match="unknown difference scheme 'backward'"):
        Ls("backward").fit([difference_record()], resolve("kt"))
