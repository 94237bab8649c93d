"""The bank: every cause as parameters that are zero where it is absent.

A cause's function builds, for the estimator at hand, its variants (each a tuple of parameters), or returns the reason
why the model or the channels cannot carry it.  Its docstring is the physics that `helmbench list causes` shows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from inspect import cleandoc
from typing import NamedTuple

import numpy as np

from ..methods.innovations.estimator import Estimator, Parameter, Setting
from ..models.families.extensions import EXTENSIONS

DEGREE = np.pi / 180.0
GRAVITY = 9.81
Variant = tuple[Parameter, ...]
Build = Callable[[Estimator], "list[Variant] | str"]


class Polar(NamedTuple):
    """How a pair (north, east) per record is reported: parameter names of speed and direction, and whether it is
    where from."""

    speed: str
    direction: str
    coming_from: bool


@dataclass(frozen=True)
class Cause:
    """One cause of the taxonomy.

    scan : values of the first parameter that a refit tries as starts, beside zero.
    rings : sizes of (north, east) pairs that a refit tries, each in eight directions and record by record.
    matters : size of the first parameter whose detection the stated power is for.
    separate_by : what would tell it from its rivals.
    """

    id: str
    build: Build
    unit: str
    scan: tuple[float, ...] = ()
    rings: tuple[float, ...] = ()
    polar: Polar | None = None
    matters: float | None = None
    separate_by: str | None = None
    profile: tuple[float, ...] = ()
    """Values (s, for a 160 m ship) of the second parameter, which means nothing where the first is zero."""

    @property
    def physics(self) -> str:
        """What the cause is, in words and as an equation."""
        return cleandoc(self.build.__doc__ or "")


CAUSES: dict[str, Cause] = {}


def cause(unit: str, **facts) -> Callable[[Build], Build]:
    """Enter a function into the bank under its own name."""

    def enter(build: Build) -> Build:
        CAUSES[build.__name__] = Cause(build.__name__, build, unit, **facts)
        return build

    return enter


def _one(est: Estimator, name: str, unit: str, *slots: str, scale: float, **bounds) -> Variant:
    """A single parameter that moves some entries of the parameter vector alike."""
    return (Parameter(name, unit, tuple((est.index[slot], 1.0) for slot in slots), scale=scale, **bounds),)


def _pairs(est: Estimator, names: tuple[str, str], unit: str, slots: tuple[str, str], scale: float) -> Variant:
    """Two components for every record."""
    return tuple(
        Parameter(name, unit, ((est.index[slot], 1.0),), record=i, scale=scale)
        for i in range(len(est.data))
        for name, slot in zip(names, slots, strict=True)
    )


def _lacks(est: Estimator, *symbols: str) -> str | None:
    names = {"psi": "heading", "r": "yaw rate", "u": "surge", "v": "sway", "x": "position", "y": "position"}
    missing = [names[s] for s in symbols if not est.channels[("psi", "r", "u", "v", "x", "y").index(s)]]
    return f"needs measured {' and '.join(dict.fromkeys(missing))} that the model has" if missing else None


def _unlimited(est: Estimator) -> str | None:
    return None if est.commanded else "the rudder column is the angle itself, which already shows its limits"


def _three(est: Estimator) -> str | None:
    return None if est.model.is_3dof else "needs a model with surge, sway and yaw"


@cause(
    "rad",
    matters=0.1 * DEGREE,
    separate_by="straight runs at two speeds: what an offset does grows with the speed squared",
)
def rudder_offset(est: Estimator) -> list[Variant] | str:
    """The rudder's neutral angle: delta_hull = delta_recorded + delta0, delta0 in rad."""
    return [_one(est, "delta0", "rad", "rudder_offset", scale=0.05 * DEGREE)]


@cause(
    "1", matters=0.02, separate_by="a bollard or captive rudder-force test, or rudder angles from small to hard over"
)
def rudder_effectiveness(est: Estimator) -> list[Variant] | str:
    """Rudder force over what is modelled, as a share more: delta_hull = (1 + e) delta_recorded (-0.2: 20 % lost)."""
    return [_one(est, "e", "1", "rudder_effectiveness", scale=0.01, low=-0.95, high=2.0)]


@cause(
    "s",
    scan=(0.3, 1.0, 2.0, 3.5),
    matters=0.2,
    separate_by="rudder steps with the rudder angle recorded at the stock and on the bridge at once",
)
def rudder_delay(est: Estimator) -> list[Variant] | str:
    """The hull feels the rudder late: delta_hull(t) = delta_recorded(t - tau), tau in s."""
    return [_one(est, "tau", "s", "rudder_delay", scale=0.05, low=0.0, high=8.0)]


@cause(
    "rad",
    scan=(0.15 * DEGREE, 0.4 * DEGREE, DEGREE, 2 * DEGREE),
    matters=0.3 * DEGREE,
    separate_by="slow small-angle rudder sweeps in both directions",
)
def rudder_backlash(est: Estimator) -> list[Variant] | str:
    """Play of +- b rad between the recorded and the acting rudder (linkage wear): the hull's rudder follows only
    once the recorded one has moved through it."""
    return [_one(est, "b", "rad", "rudder_play", scale=0.1 * DEGREE, low=0.0, high=12.0 * DEGREE)]


@cause("1, s", matters=0.1, separate_by="a rudder-force check before and after")
def rudder_fault(est: Estimator) -> list[Variant] | str:
    """Sudden loss (or gain) of rudder force: effectiveness 1 + e from time t0 (s) of the record on."""
    return [fault_variant(est, None)]


def fault_variant(est: Estimator, record: int | None) -> Variant:
    """Effectiveness 1 + e from time t0 (s) on."""
    e = Parameter("e", "1", ((est.index["fault"], 1.0),), record, -1.0, 1.0, 0.02)
    return (e, Parameter("t0", "s", ((est.index["fault_time"], 1.0),), record, 0.0, float(est.data[0].time[-1]), 1.0))


@cause("rad/s, 1, rad", separate_by="heading and rate sampled at several times the wave frequency")
def wave_motion(est: Estimator) -> list[Variant] | str:
    """First-order wave motion on heading and yaw rate: second-order narrow-band noise, peak frequency omega (rad/s),
    damping ratio and rms (rad)."""
    return [()]


@cause("s", separate_by="time stamps taken by the instruments")
def clock_jitter(est: Estimator) -> list[Variant] | str:
    """Samples taken at t + error while the time column says t: error of standard deviation sd (s), independent from
    sample to sample; channels are noisier where they change fast."""
    return [()]


@cause("rad/s", separate_by="record the rudder angle itself beside the command")
def rudder_rate_limit(est: Estimator) -> list[Variant] | str:
    """The rudder cannot turn faster than a rate (rad/s); only where the rudder column is a command."""
    return _unlimited(est) or [_one(est, "rate", "rad/s", "rudder_rate", scale=0.01 * DEGREE, low=0.0)]


@cause("rad", separate_by="record the rudder angle itself beside the command")
def rudder_saturation(est: Estimator) -> list[Variant] | str:
    """The rudder stops at an angle (rad) short of the command; only where the rudder column is a command."""
    return _unlimited(est) or [_one(est, "limit", "rad", "rudder_limit", scale=0.05 * DEGREE, low=0.0)]


@cause("rad/s", matters=0.003 * DEGREE, separate_by="a gyro zero reading at rest")
def yaw_rate_bias(est: Estimator) -> list[Variant] | str:
    """Zero error of the rate gyro: recorded yaw rate = true + b, b in rad/s."""
    return _lacks(est, "r") or [_one(est, "b", "rad/s", "bias_r", scale=0.002 * DEGREE)]


@cause("1", matters=0.01, separate_by="a heading channel of another instrument over a full turn")
def yaw_rate_scale(est: Estimator) -> list[Variant] | str:
    """Scale error of the rate gyro: recorded yaw rate = (1 + s) true."""
    return _lacks(est, "r") or [_one(est, "s", "1", "scale_r", scale=0.005, low=-0.8, high=2.0)]


@cause("rad", matters=0.1 * DEGREE, separate_by="positions on two opposite straight courses")
def heading_offset(est: Estimator) -> list[Variant] | str:
    """Misread heading: recorded = true + b, b in rad; the track shows it."""
    return _lacks(est, "psi", "x", "y") or [_one(est, "b", "rad", "bias_psi", scale=0.05 * DEGREE)]


@cause("1", matters=0.002, separate_by="a measured mile in both directions")
def speed_scale(est: Estimator) -> list[Variant] | str:
    """Scale error of the speed log: recorded surge and sway = (1 + s) true."""
    return _lacks(est, "u", "v") or [_one(est, "s", "1", "scale_u", "scale_v", scale=0.002, low=-0.8, high=2.0)]


@cause("m/s", matters=0.005, separate_by="a straight run with positions")
def sway_offset(est: Estimator) -> list[Variant] | str:
    """Zero error of the log's athwartships axis: recorded sway = true + b, b in m/s."""
    return _lacks(est, "v") or [_one(est, "b", "m/s", "bias_v", scale=0.005)]


@cause(
    "s",
    scan=(0.1, 0.4, 1.0, 2.0),
    matters=0.2,
    separate_by="yaw rate and heading of instruments with known time stamps",
)
def heading_delay(est: Estimator) -> list[Variant] | str:
    """Late heading: recorded(t) = true(t - tau), tau in s."""
    return _lacks(est, "psi") or [_one(est, "tau", "s", "delay_psi", scale=0.05, low=0.0, high=5.0)]


@cause("s", scan=(0.3, 1.0, 2.0, 3.5), matters=0.2, separate_by="time stamps of each instrument")
def velocity_delay(est: Estimator) -> list[Variant] | str:
    """Late velocities: surge and sway (in a second variant yaw rate and heading too) recorded a time tau [s] late
    against the position."""
    late = {"scale": 0.05, "low": 0.0, "high": 8.0}
    four = ("delay_u", "delay_v", "delay_r", "delay_psi")
    return _lacks(est, "u", "v") or [
        _one(est, "tau", "s", "delay_u", "delay_v", **late), _one(est, "tau", "s", *four, **late)
    ]  # fmt: skip


@cause(
    "rad",
    matters=0.1 * DEGREE,
    separate_by="positions on a straight course: the track's direction against heading and log",
)
def axis_misalignment(est: Estimator) -> list[Variant] | str:
    """Speed log turned on its mount: recorded surge = u cos a + v sin a, sway = -u sin a + v cos a, a in rad."""
    return _lacks(est, "u", "v") or [_one(est, "angle", "rad", "misalignment", scale=0.05 * DEGREE, low=-0.8, high=0.8)]


@cause(
    "m/s, rad",
    rings=(0.02, 0.1, 0.4),
    polar=Polar("speed", "towards", False),
    matters=0.05,
    separate_by="the same manoeuvre on two headings, or a log that measures speed through the water",
)
def current(est: Estimator) -> list[Variant] | str:
    """Steady uniform current, earth-fixed and per record: the hull's forces depend on velocities through the water;
    speed m/s and the direction (rad) it flows towards."""
    return _three(est) or [_pairs(est, ("speed", "towards"), "m/s", ("current_n", "current_e"), 0.01)]


@cause(
    "m/s, rad",
    rings=(3.0, 7.0, 13.0),
    polar=Polar("speed", "from", True),
    matters=3.0,
    separate_by="an anemometer, or the same manoeuvre on two headings and at two speeds",
)
def wind(est: Estimator) -> list[Variant] | str:
    """Mean wind, earth-fixed and per record, on the vessel's windage; speed m/s and direction (rad) it blows from."""
    return _three(est) or [_pairs(est, ("speed", "from"), "m/s", ("wind_n", "wind_e"), 1.0)]


@cause(
    "m, rad",
    rings=(1e-5, 1e-4, 1e-3),
    polar=Polar("Hs", "from", True),
    separate_by="a wave buoy, or the same manoeuvre on two headings",
)
def wave_drift(est: Estimator) -> list[Variant] | str:
    """Mean second-order wave force, per record: rho g Hs^2 L times coefficients of the encounter angle chi,
    CX = -.010 cos chi (times .3 in following seas), CY = -.020 sin chi |sin chi|, CN = -.002 sin 2 chi."""
    return _three(est) or [_pairs(est, ("Hs", "from"), "m", ("drift_n", "drift_e"), 1e-5)]


def drift_height(est: Estimator, amount: float) -> float:
    """Significant wave height (m) of a drift amount in force units."""
    p = est.model.particulars
    return float(np.sqrt(max(amount, 0.0) * est.unit[0] / (p.get("rho", 1025.0) * GRAVITY * p.get("L", 1.0))))


@cause("N, N m", separate_by="straight runs at two speeds: a constant force does not grow with the speed")
def constant_force(est: Estimator) -> list[Variant] | str:
    """Constant force in body axes, X and Y in N and N in N m (a towed sonar, a bent fin, asymmetric thrust)."""
    if not est.model.is_3dof:
        return "in a response model a constant moment is a rudder offset"
    single = [
        Parameter(name, unit, ((est.index[f"force_{i}"], 1.0 / est.unit[i]),), scale=1e-6 * est.unit[i])
        for i, (name, unit) in enumerate((("X", "N"), ("Y", "N"), ("N", "N m")))
    ]
    return [*((p,) for p in single), tuple(single)]


def _term(est: Estimator, name: str, unit: str, slot: str, weight: float = 1.0, scale: float = 1e-5) -> Parameter:
    return Parameter(name, unit, ((est.index[slot], weight),), scale=scale / abs(weight))


def _has(est: Estimator, slot: str) -> str | None:
    return None if slot in est.index else "the model has this term already, or no place for it"


def _yaw_weight(est: Estimator) -> float:
    """What turns alpha of T r_dot + r + alpha d(r) = K delta into a term of the highest derivative."""
    if est.model.is_3dof:
        return 1.0
    c = dict(zip(est.model.coordinates, est.model.coefficients, strict=True))
    return float(c.get("a2", c.get("a", -1.0)))


@cause("1 (prime) or s/rad", separate_by="turning circles at several rudder angles, to both sides")
def yaw_damping_quadratic(est: Estimator) -> list[Variant] | str:
    """Yaw moment N r|r| (bilge keels, skeg separation), in the vessel's own prime system; for a response model
    alpha r|r| beside r, in s/rad."""
    return _has(est, "added_Nr_absr") or [(_term(est, "Nrr", "1", "added_Nr_absr", _yaw_weight(est)),)]


@cause("1 (prime) or s2/rad2", separate_by="turning circles at several rudder angles, to both sides")
def yaw_damping_cubic(est: Estimator) -> list[Variant] | str:
    """Yaw moment N r^3, in the vessel's own prime system; for a response model alpha r^3 beside r, in s2/rad2."""
    return _has(est, "added_Nrrr") or [(_term(est, "Nrrr", "1", "added_Nrrr", _yaw_weight(est)),)]


@cause("1", separate_by="hard turns with sway measured, or an oblique towing test")
def sway_damping_quadratic(est: Estimator) -> list[Variant] | str:
    """Cross-flow drag Y v|v|, in the vessel's own prime system."""
    return _three(est) or _has(est, "added_Yv_absv") or [(_term(est, "Yvv", "1", "added_Yv_absv"),)]


@cause("1", separate_by="turns with sway measured at several drift angles")
def crossflow_coupling(est: Estimator) -> list[Variant] | str:
    """Cross-flow of drift and turn: Y r|v|, Y v|r|, N v|r|, N r|v|, in the vessel's own prime system."""
    slots = {"Yrv": "added_Yr_absv", "Yvr": "added_Yv_absr", "Nvr": "added_Nv_absr", "Nrv": "added_Nr_absv"}
    if not est.model.is_3dof or "added_Yr_absv" not in est.index:
        return _three(est) or "the model has these terms already"
    single = [_term(est, name, "1", slot) for name, slot in slots.items()]
    return [*((p,) for p in single), tuple(single)]


@cause("1", matters=0.02, separate_by="the draught, or a stopping and a turning test at two loadings")
def loading_change(est: Estimator) -> list[Variant] | str:
    """Rigid-body mass and yaw inertia (with the centripetal terms they carry) differ by a common fraction."""
    if not est.model.is_3dof:
        return "a response model has no mass of its own: its time constants take it up (coefficient_shift)"
    if not est.base[est.index["rigid_mass"]] > 0.0:
        return "the vessel file gives no displacement"
    return [_one(est, "fraction", "1", "loading_fraction", scale=0.01, low=-0.8, high=2.0)]


SHALLOW = {
    "abkowitz": ("Yv", "Nv", "Nr"), "mmg-son-nomoto": ("Yuv", "Nuv", "Nur"), "mmg": ("Y_v", "N_v", "N_r"),
    "mmg-fixed-speed": ("Yuv", "Nuv", "Nur"),
}  # fmt: skip


@cause("1", scan=(0.05, 0.1, 0.2, 0.4, 0.6, 0.8), separate_by="an echo sounder, or the same manoeuvre in deep water")
def shallow_water(est: Estimator) -> list[Variant] | str:
    """Depth over draught h/d: Y_v, N_v and N_r grow as in Hirano et al. 1985 (Inoue's formulas with the effective
    aspect ratio k_e = k/(d k/(2 h) + (x cot x)^q), x = pi d/(2 h), q = 2.3, 1.7, .7)."""
    names = SHALLOW.get(est.model.family.split("+")[0])
    p = est.model.particulars
    if names is None or not {"L", "d", "nabla"} <= set(p):
        return "stated for 3-DOF models with L, d and displacement only"
    values = [est.base[est.index[name]] for name in names]
    slots = tuple((est.index[name], value) for name, value in zip(names, values, strict=True))
    law = lambda inverse: shallow_factors(p["L"], p["d"], p["nabla"], inverse) - 1.0  # noqa: E731
    return [(Parameter("draught_over_depth", "1", slots, law=law, low=0.0, high=0.9, scale=0.05),)]


def shallow_factors(length: float, draught: float, nabla: float, inverse: float) -> np.ndarray:
    """(3,) Y_v, N_v, N_r at draught over depth `inverse`, over those in deep water (Hirano et al. 1985)."""
    if inverse <= 0.0:
        return np.ones(3)
    k, x = 2.0 * draught / length, 0.5 * np.pi * inverse
    ke = k / (0.5 * k * inverse + (x / np.tan(x)) ** np.array([2.3, 1.7, 0.7]))
    block = 1.4 * nabla / (length**2 * draught)
    sway = (0.5 * np.pi * ke[0] + block) / (0.5 * np.pi * k + block)
    return np.array([sway, ke[1] / k, (0.54 * ke[2] - ke[2] ** 2) / (0.54 * k - k**2)])


@cause("1", matters=0.1, separate_by="a manoeuvre that excites the coefficient's own term")
def coefficient_shift(est: Estimator) -> list[Variant] | str:
    """One coefficient of the base model differs by a fraction (`details` names it)."""
    names = [n for n, c in zip(est.model.coordinates, est.model.coefficients, strict=True) if c != 0.0 and n[1:] != "0"]
    public = _public_shifts(est) if est.model.kernels.PUBLISHED else []
    return public or [
        (Parameter(f"fraction:{n}", "1", ((est.index[n], est.base[est.index[n]]),), scale=0.01, low=-0.95),)
        for n in names
    ]


def _public_shifts(est: Estimator) -> list[Variant]:
    """Published parameters (K, T, ...) in the place of coefficients: one of them may move several."""
    model = est.model
    p0 = model.to_parameters(model.coefficients)
    if not np.isfinite(p0).all():
        return []
    slots = tuple((est.index[name], 1.0) for name in model.coordinates)

    def law(j: int) -> Callable[[float], np.ndarray]:
        def moved(fraction: float) -> np.ndarray:
            p = p0.copy()
            p[j] *= 1.0 + fraction
            return model.from_parameters(p) - model.coefficients

        return moved

    added = {name for extension in EXTENSIONS.values() for name in extension.units}
    return [
        (Parameter(f"fraction:{name}", "1", slots, law=law(j), scale=0.01, low=-0.9, high=5.0),)
        for j, name in enumerate(model.parameter_names)
        if p0[j] != 0.0 and name not in added and name != "K"  # K is the rudder's effectiveness
    ]


@cause("s2/rad2", profile=(10.0, 30.0, 100.0, 300.0), separate_by="record the speed through the water")
def speed_loss(est: Estimator) -> list[Variant] | str:
    """Speed lost in the turn, for response models: U = U0 (1 - loss), T_u loss_dot = k r^2 - loss, and every term of
    the yaw equation keeps its prime value at the speed U (damping falls with U, the rudder's moment with U^2)."""
    if "loss_gain" not in est.index:
        return "surge is a state of the model already"
    gain = _term(est, "loss_gain", "s2/rad2", "loss_gain", scale=10.0)
    time = Parameter(
        "recovery",
        "s",
        ((est.index["loss_time"], 1.0),),
        scale=1.0,
        low=3.0 * est.clock - 30.0,
        high=300.0 * est.clock - 30.0,
    )
    return [(gain, time)]


@cause("s", profile=(0.5, 1.5, 5.0, 15.0, 45.0), separate_by="rudder steps with the yaw rate sampled fast")
def second_order_lead(est: Estimator) -> list[Variant] | str:
    """Second time constant T2 and lead T3 that a first-order Nomoto model lacks: rudder through
    (1 + T3 s)/(1 + T2 s), T3 = T2 (1 - lead)."""
    if "lead" not in est.index:
        return "only for first-order response models: others have it"
    lead = Parameter("lead", "1", ((est.index["lead"], 1.0),), scale=0.02, low=-20.0, high=5.0)
    step = float(np.median(np.diff(est.data[0].time)))  # what is faster than the sampling is not told
    base = est.base[est.index["lead_T2"]]
    time = Parameter("T2", "s", ((est.index["lead_T2"], 1.0),), scale=0.2, low=step - base, high=200.0)
    return [(lead, time)]


def testable(est: Estimator) -> tuple[dict[str, list[Variant]], dict[str, str]]:
    """Variants of the causes that model and channels can carry, and for the others why not."""
    can, cannot = {}, {}
    for name, entry in CAUSES.items():
        found = entry.build(est)
        if isinstance(found, str):
            cannot[name] = found
        else:
            can[name] = found
    return can, cannot


def starts(est: Estimator, s: Setting, entry: Cause, variant: Variant) -> Sequence[Setting]:
    """Settings that a refit tries as its start: the one given, and the cause's scan."""
    clock = est.clock
    factor = clock if variant[0].unit == "s" else 1.0
    return [s, *(est.at(s, variant[0], value * factor) for value in entry.scan)]
