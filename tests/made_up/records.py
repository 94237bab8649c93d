"""Records that tests drive a model with."""

from dataclasses import replace

import numpy as np

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.models.model import CHANNELS, resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

OF_PAPER_003 = {
    "cargo-S3": ("cargo", "heading:10deg/0.0105rad_s+6deg/0.031rad_s+4deg/0.083rad_s", 6000.0),
    "cargo-S1": ("cargo", "heading:20deg/600s", 6000.0),
    "patrol-S3": ("patrol", "heading:10deg/0.12rad_s+6deg/0.5rad_s+4deg/1.6rad_s", 900.0),
}
"""Record -> ship, manoeuvre and duration, s, of paper 003."""


def percent(model, coefficients):
    """Errors of the published parameters by coefficients, %."""
    return 100.0 * (model.to_parameters(coefficients) / model.to_parameters(model.coefficients) - 1.0)


def driven(model, rudder, dt, name="driven", **options):
    """A noise-free record of a model driven by a rudder series (N,), from its straight course."""
    states = simulate(model, inputs_of(model, rudder), dt, initial_state(model), **options)
    channels = {CHANNELS[s]: states[:, i] for i, s in enumerate(model.states) if s in CHANNELS}
    return Record(dt * np.arange(len(rudder)), {"rudder_rad": np.asarray(rudder), **channels}, name)


def long_zigzag():
    """A noisy zigzag of the Mariner, of 400 s at 1 Hz."""
    return generate(Case("mariner", "zigzag:20/20", "low", seed=7, duration_s=400.0, dt_s=1.0))


def errors_of(run):
    """Root mean square error of a free run by channel."""
    return {channel: sums.scores()[0] for channel, sums in run.squares().items()}


def relative_errors(estimate, truth):
    """Relative error by name of the parameters with a non-zero truth."""
    return {k: abs(estimate.parameters[k] / value - 1.0) for k, value in truth.parameters.items() if value}


def zigzag_5_10(name):
    """5/10 zigzag of paper 002: 200 s at 0.1 s, one RK4 step a sample, rudder held."""
    model = replace(resolve(name), max_step_s=0.1)
    psi, r = model.states.index("psi"), model.states.index("r")
    states, delta, side = [initial_state(model)], np.zeros(2001), 1.0
    for k in range(2000):
        if side * states[k][psi] >= np.deg2rad(10.0):
            side = -side
        delta[k] = side * np.deg2rad(5.0) if k else 0.0
        states.append(simulate(model, [[delta[k]]] * 2, 0.1, states[k], hold="zero")[1])
    return Record(0.1 * np.arange(2001), {"rudder_rad": delta, "yaw_rate_rad_s": np.array(states)[:, r]})
