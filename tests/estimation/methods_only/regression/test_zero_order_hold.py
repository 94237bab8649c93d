"""The exact inverse map of a difference equation, against the reference values of paper 002."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.methods.registry import make
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve
from helmbench.models.simulate import zoh_matrices

from ....made_up.records import zigzag_5_10


def errors(estimate, model):
    return np.array([estimate.parameters[name] / model.parameters[name] - 1.0 for name in model.parameter_names])


def test_zoh_map_of_paper_002_second_order():
    """Reference values p002_second_noisefree_ZOHmap and p002_second_noisefree_eq6map."""
    record, model = zigzag_5_10("response-2"), resolve("response-2")
    found = make("ls", scheme="zoh").fit([record], model).parameters
    expected = {"h": 8.053756393620104, "g": 16.138547673320552, "alpha": 98.32122369399987}
    expected |= {"T3": 0.3123597473982427, "K": 0.2010017934120177}
    assert found == pytest.approx(expected, rel=1e-7)
    euler = make("ls-forward").fit([record], model).parameters
    expected = {"h": 8.88853421887575, "g": 16.240216538241842, "alpha": 98.32122369399988}
    expected |= {"T3": 0.36399627844042104, "K": 0.20100179341201774}
    assert euler == pytest.approx(expected, rel=1e-7)


def test_zoh_map_of_paper_002_first_order():
    """The logarithm of the pole reduces the error of T from .4 % to below .05 %; K and alpha are unchanged."""
    record, model = zigzag_5_10("response-1"), resolve("response-1")
    euler = make("ls-forward").fit([record], model).parameters
    found = make("ls", scheme="zoh").fit([record], model).parameters
    expected = {"T": 13.567345568117169, "K": 0.21599763092445412, "alpha": 258.3423805301469}
    assert euler == pytest.approx(expected, rel=1e-7)
    assert (found["K"], found["alpha"]) == pytest.approx((euler["K"], euler["alpha"]), rel=1e-9)
    assert abs(found["T"] / 13.514 - 1.0) < 5e-4 < abs(euler["T"] / 13.514 - 1.0)


@pytest.mark.parametrize("name", ["cargo", "remus-kt", "patrol"])
def test_zoh_map_is_exact_for_linear_models(name, rng):
    """Yaw rate sampled under a held random rudder gives the continuous parameters."""
    model = resolve(name)
    dt = model.suite["dt_s"]
    a, b = zoh_matrices(model, dt)
    delta = np.repeat(rng.normal(size=40), 10)
    x, states = np.zeros(3), []
    for angle in delta:
        states.append(x)
        x = a @ x + b[:, 0] * angle
    record = Record(dt * np.arange(400), {"rudder_rad": delta, "yaw_rate_rad_s": np.array(states)[:, 1]})
    assert np.abs(errors(make("ls", scheme="zoh").fit([record], model), model)).max() < 1e-5


def test_zoh_map_refuses_other_models_and_steps():
    records = [generate(Case("kvlcc2-l7", "zigzag:10/10", duration_s=30, dt_s=0.5))]
    with pytest.raises(CannotFit, match="no response model"):
        make("ls", scheme="zoh").fit(records, resolve("kvlcc2-l7"))
    a, b = zigzag_5_10("response-1").slice(0, 200), zigzag_5_10("response-1").slice(0, 300)
    b = Record(2.0 * b.time_s, dict(b.channels))
    with pytest.raises(CannotFit, match="equal time steps"):
        make("ls", scheme="zoh").fit([a, b], resolve("response-1"))
