"""The two vessels of paper 003 and their headings: what the paper simulates, and its equations 4-6 as matrices."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ....datasets.generator import Case, generate
from ....datasets.record import Record
from ....estimation.observers.linear import discretised, respond
from ....methods import eso_rw_lssvr as eso
from ....models.model import Model, resolve

VESSELS = ("cargo", "patrol")
DT = 0.02
DURATION = {"cargo": 6000.0, "patrol": 900.0}
TRAINING = 0.6
"""Share of the samples, from the start, that the paper identifies with."""
SINES = {
    ("cargo", "S1"): "20deg/600s",
    ("cargo", "S3"): "10deg/0.0105rad_s+6deg/0.031rad_s+4deg/0.083rad_s",
    ("patrol", "S1"): "20deg/0.27rad_s",
    ("patrol", "S3"): "10deg/0.12rad_s+6deg/0.5rad_s+4deg/1.6rad_s",
}
"""Heading references: one sine, or three.  The paper says sinusoidal and prints neither amplitude nor period."""


class SineMotion(NamedTuple):
    """Samples (N,) of a noise-free run: heading and three derivatives, rudder, its slope, the heading reference."""

    psi: np.ndarray
    r: np.ndarray
    psi_ddot: np.ndarray
    psi_dddot: np.ndarray
    delta: np.ndarray
    delta_dot: np.ndarray
    reference: np.ndarray


class LoopNumbers(NamedTuple):
    """a1 .. a4 of eq 2, the rudder's lag and the heading controller's gain."""

    a1: float
    a2: float
    a3: float
    a4: float
    lag: float
    kp: float


def numbers(vessel: str) -> LoopNumbers:
    """Of a vessel, with the gain that its file has (patrol: -0.7)."""
    model = resolve(vessel)
    t1, t2, t3, k = (model.parameters[name] for name in ("T1", "T2", "T3", "K"))
    assert model.controller is not None
    return LoopNumbers(1.0 / (t1 * t2), t1 + t2, k, t3, model.rudder.lag_s, model.controller.kp)


def closed_loop(n: LoopNumbers) -> tuple[np.ndarray, np.ndarray]:
    """Eq 6, corrected: a (4, 4), b (4, 1) of (psi, r, delta, psi_ddot) driven by the heading reference."""
    zero = n.a1 * n.a3 * n.a4 / n.lag
    a = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-n.kp / n.lag, 0.0, -1.0 / n.lag, 0.0],
            [-zero * n.kp, -n.a1, n.a1 * n.a3 - zero, -n.a1 * n.a2],
        ]
    )
    return a, np.array([[0.0], [0.0], [n.kp / n.lag], [zero * n.kp]])


def closed_loop_as_printed(n: LoopNumbers) -> np.ndarray:
    """Eq 6 as printed: -a2 on r, -(a1 a2 + a1 a3 a4/Tm) on the rudder, a1 a3 on psi_ddot."""
    a, _ = closed_loop(n)
    a[3, 1:] = [-n.a2, -n.a1 * n.a2 - n.a1 * n.a3 * n.a4 / n.lag, n.a1 * n.a3]
    return a


@lru_cache(maxsize=4)
def record(vessel: str, sines: str, euler: bool = False) -> Record:
    """The noise-free run with Table 3's number of samples, one every 0.02 s; `euler` steps the vessel as eq 11 does.

    sines : a name in `SINES`, or sines as manoeuvres write them.
    """
    text = f"heading:{SINES.get((vessel, sines), sines)}" + ("@euler" if euler else "")
    found = generate(Case(vessel, text, duration_s=DURATION[vessel], dt_s=DT))
    return found.slice(0, samples(vessel))


def samples(vessel: str) -> int:
    """Number of samples of a run."""
    return round(DURATION[vessel] / DT)


def reference_of(run: Record, vessel: str) -> np.ndarray:
    """Heading reference (N,) behind the rudder command."""
    return run.heading_unwrapped() + run.column("rudder_command_rad") / numbers(vessel).kp


@lru_cache(maxsize=4)
def motion(vessel: str, sines: str, hold: str = "zero") -> SineMotion:
    """The closed loop of corrected eq 6 from rest: 'zero' holds the reference and solves exactly, 'euler' steps."""
    a, b = closed_loop(numbers(vessel))
    reference = reference_of(record(vessel, sines), vessel)
    states = respond(discretised(a, b, DT, hold), reference[:, None], np.zeros(4))
    slopes = states @ a.T + reference[:, None] * b.T
    psi, r, delta, psi_ddot = states.T
    return SineMotion(psi, r, psi_ddot, slopes[:, 3], delta, slopes[:, 2], reference)


def seen(variant: str, psi: np.ndarray, run: SineMotion, vessel: str) -> eso.Observed:
    """What the observer at 45 rad/s makes of headings psi (N,), stepped by Euler as eq 11 does."""
    n = numbers(vessel)
    if variant == "as_printed":
        return eso.observe_as_printed(psi, run.reference, DT, n.kp, n.lag)
    return eso.observe(psi, DT, eso.PRINTED_OMEGA, "euler")


def noisy(run: Record, sd: float, rng: np.random.Generator) -> Record:
    """Heading and rudder of a run, the heading with white noise of standard deviation sd [rad]; no yaw rate."""
    heading = run.column("heading_rad") + sd * rng.normal(size=run.n)
    return run.with_channels(yaw_rate_rad_s=None, heading_rad=heading)


def percent(model: Model, coefficients: np.ndarray) -> np.ndarray:
    """Errors (4,) of T1, T2, T3, K in percent; nan where T1 and T2 are complex."""
    truth = model.to_parameters(model.coefficients)
    return 100.0 * (model.to_parameters(coefficients) / truth - 1.0)


def rms(values: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))
