"""Paper 003's studies; Tables 4 to 6 also over what it does not print: the sines of the heading reference, the noise.

`vessels` has the vessels and their runs, `states` Table 4, `identification` Tables 5 and 6, `proposed` the proposal as
a whole with its bee colony, `robustness` the effect of outliers.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ....estimation.methods_only.svr import adaptive_weights
from ....estimation.observers.linear import noise_gains
from ....methods import eso_rw_lssvr as eso
from ....methods.ls_svr import DOMAIN
from ....models.model import resolve
from ..study import PaperStudy, StudyResult, settings_at
from . import identification, proposed, robustness, states, vessels
from .vessels import VESSELS

UNEQUAL = np.array([-40.0, -45.0, -50.0, -55.0])
STATES = ("psi", "r", "psi_ddot", "z5")
MOTION = ("psi", "r", "psi_ddot", "psi_dddot", "delta")


def settings(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Everything that needs no noise and no fit."""
    values: dict[str, float] = {}
    for vessel in VESSELS:
        values |= {f"{vessel}_{key}": value for key, value in _vessel(vessel).items()}
    gains = eso.gains([-eso.PRINTED_OMEGA] * 4)
    values |= dict(zip(("l1", "l2", "l4", "l5"), gains.tolist(), strict=True))
    for method in eso.METHODS:
        found = noise_gains(eso.sampled_observer(eso.PRINTED_OMEGA, vessels.DT, method))
        values |= {f"{method}_gain_{name}": value for name, value in zip(STATES, found.tolist(), strict=True)}
    values |= {"l3": eso.PRINTED_L3, "domain_low": DOMAIN[0], "domain_high": DOMAIN[1]}
    values |= {"dimension": 1, "dt": vessels.DT}
    return StudyResult(values | _equations())


def _vessel(vessel: str) -> dict[str, float]:
    model, n = resolve(vessel), vessels.numbers(vessel)
    found = dict(model.parameters) | {"Tm": n.lag, "time": vessels.DURATION[vessel], "samples": vessels.samples(vessel)}
    a1, a2, b1, b2 = model.coefficients.tolist()
    found |= {"theta1": a1, "theta2": a2, "theta3": b2, "theta4": b1}
    poles = sorted(np.linalg.eigvals(vessels.closed_loop(n)[0]), key=lambda pole: (pole.real, pole.imag))
    found |= {"pole1": poles[0].real, "pole2": poles[1].real, "pole3": poles[2].real, "pole3_im": poles[3].imag}
    printed = vessels.closed_loop_as_printed(n._replace(kp=abs(n.kp)))
    found |= {"stable": _growth(vessels.closed_loop(n)[0]) < 0.0, "stable_as_printed": _growth(printed) < 0.0}
    run = vessels.motion(vessel, "S3")
    return found | {f"sd_{name}": float(np.std(getattr(run, name))) for name in MOTION}


def _growth(a: np.ndarray) -> float:
    """Largest real part of the poles."""
    return float(np.linalg.eigvals(a).real.max())


def _equations() -> dict[str, float]:
    """Statements on single equations: corrected form, and `_as_printed`."""
    n, gains = vessels.numbers("cargo"), eso.gains([-eso.PRINTED_OMEGA] * 4)
    a, _ = eso.printed_observer(gains, eso.PRINTED_L3, n.kp, n.lag)
    plain, _ = eso.printed_observer(gains, 0.0, n.kp, n.lag)
    coupled = a.copy()
    coupled[3, 1] = 1.0  # M(4, 2) of eq 18 as printed, in the order psi, r, rudder, psi_ddot, z5
    return {
        "rudder_settles": -1.0 / n.lag < 0.0,
        "rudder_settles_as_printed": 1.0 / n.lag < 0.0,
        "l3_without_effect": bool(np.allclose(np.poly(a), np.poly(plain), rtol=1e-9)),
        "eq18_gives_eq19": _is_eq19(a, gains, n.lag),
        "eq18_gives_eq19_as_printed": _is_eq19(coupled, gains, n.lag),
        "eq20_places_poles": _places(eso.gains(UNEQUAL)),
        "eq20_places_poles_as_printed": _places(_gains_as_printed(UNEQUAL)),
        **_recovered(),
        **_weights(),
    }


def _is_eq19(a: np.ndarray, gains: np.ndarray, lag: float) -> bool:
    expected = np.polymul([1.0, 1.0 / lag], [1.0, *gains])
    return bool(np.allclose(np.poly(a), expected, rtol=1e-9))


def _gains_as_printed(poles: np.ndarray) -> np.ndarray:
    """Eq 20 as printed: the product of the first and the last pole twice, that of the second and the last missing."""
    first, second, _, fifth = poles
    gains = eso.gains(poles)
    gains[1] += first * fifth - second * fifth
    return gains


def _places(gains: np.ndarray) -> bool:
    a, _ = eso.observer(gains)
    return bool(np.allclose(np.sort(np.linalg.eigvals(a)), np.sort(UNEQUAL), rtol=1e-6))


def _recovered() -> dict[str, float]:
    """Eq 31 on the true theta of both vessels: the largest relative error of a parameter."""
    found = {"eq31": 0.0, "eq31_as_printed": 0.0}
    for vessel in VESSELS:
        model = resolve(vessel)
        a1, a2, b1, _ = model.coefficients
        truth = np.array([model.parameters[name] for name in model.parameter_names])
        root = 0.5 * np.sqrt((a1 / a2) ** 2 + 4.0 / a2)
        printed = np.array([0.5 * a1 / a2 - root, 0.5 * a1 / a2 + root, 1.0, -b1 / a2])  # T3: a sum over itself
        corrected = model.to_parameters(model.coefficients)
        for key, values in (("eq31", corrected), ("eq31_as_printed", printed)):
            found[key] = max(found[key], float(np.abs(values / truth - 1.0).max()))
    return {key: value < 1e-9 for key, value in found.items()}


def _weights() -> dict[str, float]:
    """Whether a larger error has a smaller weight, on errors of both signs (eq 26-27)."""
    errors = np.linspace(-2.0, 3.0, 400)
    order = np.argsort(np.abs(errors))
    forms = {"weights_fall": False, "weights_fall_as_printed": True}
    found = {key: adaptive_weights(errors, signed)[order] for key, signed in forms.items()}
    return {key: bool((np.diff(weights) <= 1e-12).all()) for key, weights in found.items()}


SINES = {
    "cargo": {1: ((1.0, 0.0105),), 3: ((1.0, 0.0105), (0.6, 0.031), (0.4, 0.083))},
    "patrol": {1: ((1.0, 0.27),), 3: ((1.0, 0.12), (0.6, 0.5), (0.4, 1.6))},
}
"""Shares of the amplitude and frequencies, rad/s, before scaling."""


def _sines(vessel: str, chosen: dict[str, Any]) -> str:
    """The heading reference of a point, as manoeuvres write it."""
    parts = SINES[vessel][chosen["number of sines"]]
    amplitude, factor = chosen["amplitude"], chosen["frequency factor"]
    return "+".join(f"{share * amplitude:.6f}deg/{factor * omega:.9f}rad_s" for share, omega in parts)


def states_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Table 4, ESO: RMSE and R^2 of both forms of the observer at one point."""
    chosen = settings_at("003", f"states_{vessel}_searched", index)
    truth = vessels.motion(vessel, _sines(vessel, chosen), "euler")
    noise = chosen["heading noise"] * np.random.default_rng(index).normal(size=len(truth.psi))
    values: dict[str, float] = {}
    for variant in ("corrected", "as_printed"):
        seen = states.observed(variant, truth.psi + noise, truth, vessel)
        values |= states.scores(f"{variant}_eso", seen, truth, vessel)
    return StudyResult(values)


def motions_searched(rng: np.random.Generator, *, index: int) -> StudyResult:
    """What Tables 4 to 6 imply, on the noise-free motions of one point."""
    chosen = settings_at("003", "motions_searched", index)
    values: dict[str, float] = {}
    for vessel in vessels.VESSELS:
        values |= identification.of_motion(vessel, _sines(vessel, chosen))
    return StudyResult(values)


def identified_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Tables 5 and 6: both methods, corrected and as printed, at one point; its noise belongs to the point."""
    chosen = settings_at("003", f"identified_{vessel}_searched", index)
    own = np.random.default_rng(index)
    found = identification.on_sines(vessel, _sines(vessel, chosen), chosen["heading noise"], own)
    return StudyResult(found.values)


STUDIES = {
    "settings": PaperStudy(settings),
    "arithmetic": PaperStudy(identification.arithmetic),
    "noise_free": PaperStudy(identification.noise_free),
    "rule": PaperStudy(robustness.rule),
    "states_cargo": PaperStudy(partial(states.table_4, "cargo"), seeds=8),
    "states_patrol": PaperStudy(partial(states.table_4, "patrol"), seeds=20),
    "observers_cargo": PaperStudy(partial(states.observers, "cargo"), seeds=3),
    "observers_patrol": PaperStudy(partial(states.observers, "patrol"), seeds=8),
    "identified_cargo": PaperStudy(partial(identification.tables_5_and_6, "cargo"), seeds=20),
    "identified_patrol": PaperStudy(partial(identification.tables_5_and_6, "patrol"), seeds=40),
    "states_cargo_searched": PaperStudy(partial(states_searched, "cargo"), seeds=24),
    "states_patrol_searched": PaperStudy(partial(states_searched, "patrol"), seeds=32),
    "motions_searched": PaperStudy(motions_searched, seeds=32),
    "identified_cargo_searched": PaperStudy(partial(identified_searched, "cargo"), seeds=12),
    "identified_patrol_searched": PaperStudy(partial(identified_searched, "patrol"), seeds=24),
    "crossover_cargo": PaperStudy(partial(states.crossover, "cargo")),
    "crossover_patrol": PaperStudy(partial(states.crossover, "patrol")),
    "aligned": PaperStudy(identification.aligned, seeds=5),
    "sensitivity": PaperStudy(robustness.sensitivity, seeds=20),
    "outliers": PaperStudy(robustness.outliers, seeds=150),
    "efficiency": PaperStudy(robustness.efficiency, seeds=12),
    "proposed": PaperStudy(proposed.proposed, seeds=3, drawn=3),
}
