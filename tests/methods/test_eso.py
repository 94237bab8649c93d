"""Extended state observer against the reference values of paper 003's corrected equations."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.observers.linear import noise_gains, respond
from helmbench.methods import eso_rw_lssvr as eso
from helmbench.models.model import resolve

from ..made_up.records import OF_PAPER_003, percent


def least_squares(observed, rudder, slope):
    """Coefficients (a1, a2, b1, b2) from the first 60 % of the rows."""
    n = int(0.6 * len(rudder))
    x = np.column_stack([observed.psi_ddot, observed.r, rudder, slope])[:n]
    size = np.linalg.norm(x, axis=0)
    return np.linalg.lstsq(x / size, observed.psi_dddot[:n], rcond=None)[0] / size


def test_gains_of_table_3():
    assert eso.gains([-45.0] * 4).tolist() == [180.0, 12150.0, 364500.0, 4100625.0]


def test_gains_place_the_poles(rng):
    real, imaginary = -rng.uniform(0.1, 2.0, 3), rng.uniform(0.1, 2.0)
    poles = np.array([real[0], real[1], real[2] + 1j * imaginary, real[2] - 1j * imaginary])
    a, _ = eso.observer(eso.gains(poles))
    assert np.sort_complex(np.linalg.eigvals(a)) == pytest.approx(np.sort_complex(poles), rel=1e-8)


@pytest.mark.parametrize("poles", [[-1.0] * 3, [-1.0, -1.0, -1.0, 0.5], [-1.0, -1.0, -1.0, -1.0 + 1.0j]])
def test_bad_poles_are_refused(poles):
    with pytest.raises(ValueError, match="four poles"):
        eso.gains(poles)


def test_the_determinant_is_that_of_equation_19(rng):
    """(s + 1/Tm)(s^4 + l1 s^3 + l2 s^2 + l4 s + l5), whatever l3 and kp are."""
    gain, lag = rng.uniform(1.0, 5.0, 4), 2.5
    a, _ = eso.printed_observer(gain, rng.normal(), rng.normal(), lag)
    expected = np.poly1d([1.0, 1.0 / lag]) * np.poly1d([1.0, *gain])
    assert np.poly(a) == pytest.approx(expected.coeffs, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("method", "reference"),
    [("euler", [6.0950, 603.15, 21901.0, 276950.0]), ("exact", [2.6868, 122.31, 2872.5, 27268.0])],
)
def test_noise_gains_at_45_rad_s(method, reference):
    assert noise_gains(eso.sampled_observer(45.0, 0.02, method)) == pytest.approx(reference, rel=1e-4)


@pytest.mark.parametrize("omega0", [0.01, 1.0, 45.0, 1000.0])
def test_the_exact_observer_has_its_poles_at_every_speed(omega0):
    system = eso.sampled_observer(omega0, 0.02)
    free = np.linalg.matrix_power(system.a, 4)
    pole = np.exp(-omega0 * 0.02)
    assert np.trace(system.a) == pytest.approx(4.0 * pole, rel=1e-9)
    assert np.linalg.det(system.a) == pytest.approx(pole**4, rel=1e-6)
    assert np.trace(free) == pytest.approx(4.0 * pole**4, rel=1e-6)


def test_a_cubic_heading_is_observed_exactly(rng):
    """psi_dddot constant and no input gain: no error is left in any state."""
    c = rng.normal(size=4)
    t = 0.1 * np.arange(600)
    psi = c[0] + c[1] * t + c[2] * t**2 / 2.0 + c[3] * t**3 / 6.0
    observed = eso.observe(psi, 0.1, 1.0)
    assert observed.psi_dddot[-1] == pytest.approx(c[3], rel=1e-7, abs=1e-9)
    assert observed.psi_ddot[-1] == pytest.approx(c[2] + c[3] * t[-1], rel=1e-7, abs=1e-9)
    assert observed.psi[-1] == pytest.approx(psi[-1], rel=1e-9)


def test_a_known_input_through_b0(rng):
    """psi_dddot = b0 u with known b0 and u: only a transient is left, (omega0 t)^3/6 e^(-omega0 t)."""
    u = rng.normal(size=200)
    chain = eso.sampled_observer(1e-9, 0.1, b0=0.3)
    a, now = chain.a.copy(), chain.now[:, 1:]
    a[:, 0] += chain.now[:, 0]  # the chain without its correction
    truth = respond(chain._replace(a=a, now=now, ahead=np.zeros((4, 1))), u[:, None], np.array([0.0, 0.0, 0.0, 0.0]))
    observed = eso.observe(truth[:, 0], 0.1, 2.0, b0=0.3, u=u)
    assert observed.psi_dddot[100:] == pytest.approx(0.3 * u[100:], abs=1e-5 * abs(u[0]) + 1e-9)
    blind = eso.observe(truth[:, 0], 0.1, 2.0)
    assert np.std(blind.psi_dddot[100:] - 0.3 * u[100:]) > 0.1


def test_unknown_discretisation():
    with pytest.raises(ValueError, match="unknown method"):
        eso.sampled_observer(1.0, 0.1, "tustin")


@pytest.mark.parametrize(
    ("name", "reference"),
    [
        ("cargo-S3", [0.198, 3.63, 2.87, 0.033]),
        ("cargo-S1", [0.092, 3.07, 2.22, 0.006]),
        ("patrol-S3", [0.76, -51.1, -80.7, 0.043]),
    ],
)
def test_noise_free_least_squares_behind_the_observer(name, reference):
    """Euler plant and Euler ESO at 45 rad/s, b0 = 0: the reference's errors of T1, T2, T3, K in percent."""
    ship, text, duration = OF_PAPER_003[name]
    record = generate(Case(ship, text + "@euler", duration_s=duration, dt_s=0.02))
    rudder = record.rudder()
    observed = eso.observe(record.heading_unwrapped(), 0.02, 45.0, "euler")
    found = percent(resolve(ship), least_squares(observed, rudder, np.append(np.diff(rudder) / 0.02, 0.0)))
    assert found == pytest.approx(reference, rel=5e-3, abs=6e-4)


@pytest.mark.parametrize(
    ("name", "reference"),
    [("cargo-S3", [0.386, -100.4, -37.9, 2.86]), ("patrol-S3", [0.99, -118.0, -214.0, -0.26])],
)
def test_noise_free_least_squares_behind_the_printed_observer(name, reference):
    """b0 = 1, l3 = 100: T2 and T3 are not identified (rudder and its slope not filtered)."""
    ship, text, duration = OF_PAPER_003[name]
    model = resolve(ship)
    record = generate(Case(ship, text + "@euler", duration_s=duration, dt_s=0.02))
    kp, lag, psi, rudder = model.controller.kp, model.rudder.lag_s, record.heading_unwrapped(), record.rudder()
    command = record.column("rudder_command_rad")
    observed = eso.observe_as_printed(psi, psi + command / kp, 0.02, kp, lag)
    found = percent(model, least_squares(observed, rudder, (command - rudder) / lag))
    assert found == pytest.approx(reference, rel=0.02, abs=0.01)
