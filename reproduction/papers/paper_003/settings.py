"""Table 3 and section 2-3: the settings, the closed loops, the observer's gains, and the equations as they stand."""

from __future__ import annotations

import numpy as np

from ....estimation.methods_only.observers import eso
from ....estimation.methods_only.svr.solve import adaptive_weights
from ....estimation.observers.linear import noise_gains
from ....methods.ls_svr import DOMAIN
from ....models.model import resolve
from ..study import StudyResult
from . import vessels
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
