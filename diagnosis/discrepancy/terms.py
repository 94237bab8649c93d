"""Ways in which a base model may be wrong, as parameters of the filter with Gaussian priors.

A hull is symmetric and has no memory: surge forces are even, side forces and yaw moments odd in sway, yaw rate and
rudder, and no term knows time or heading.  So a discrepancy made of such terms cannot imitate what is none of the
hull's.  The terms fall into groups, each with one variance: numbers of the model (in prior standard deviations of the
family), the ship's own asymmetry (in units of what ASYMMETRY of rudder does), and further forces by axis (in force
units, each of rms one).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.settings import Parameter
from ...models.coefficient_groups import stated_groups
from ..residuals.features import lagged

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations

ASYMMETRY = np.deg2rad(0.3)
"""Rudder angle whose force a ship's own asymmetry is measured in."""
SHARE = 0.2
"""Prior standard deviation of a number that no group of the family holds, as a share of its value."""
AS_CAUSE = ("rudder_force", "neutral_rudder_angle", "asymmetry")
"""Groups of numbers that act as a cause of the bank does, or that stand among the terms in another form."""
OWN_SIDE = ("Y0", "N0", "Yu", "Yuu", "Nu", "Nuu")
"""Abkowitz coefficients of a ship that is not symmetric."""
EVEN = ("u", "uu", "vv", "rr", "vr", "dd", "vd", "rd", "udd", "uvv", "urr")
ODD = (
    *("v", "r", "d", "uv", "ur", "ud", "vvv", "vvr", "vrr", "rrr", "ddd", "v|v|", "r|r|", "v|r|", "r|v|"),
    *("vvd", "vdd", "rrd", "rdd", "uud"),
)
YAW_ONLY = ("r", "d", "rrr", "ddd", "r|r|", "rrd", "rdd", "d|r|")
LAGS_S = (5.0, 15.0, 45.0)
"""Lags (s, of a 160 m ship) by which sway and speed, which a response model lacks, follow rudder and yaw rate."""
CUBED_LAG_S, FAST_S, SLOWED_S = 15.0, 2.0, 60.0
NUMBERS, SIDE, FORCES = 0, 1, 2
"""Groups: the model's numbers, the asymmetry, and from FORCES on the axes of the forces."""
EMPTY = 1e-14
"""Rms of a signal that counts as none."""


@dataclass(frozen=True)
class Terms:
    """The discrepancy: parameters (m), the group of each (m,), and the variance of the asymmetry relative to that of
    the numbers that it is not allowed to fall below."""

    parameters: tuple[Parameter, ...]
    group: np.ndarray
    least_side: float

    @property
    def simulating(self) -> np.ndarray:
        """(m,) terms that are numbers of the model, so that a simulation can carry them."""
        return np.array([bool(p.slots) for p in self.parameters])


def terms_of(est: Estimator, now: Innovations) -> Terms:
    """The discrepancy of a model on records; forces are made from the filter's states at a run.

    Eqs. 3, 4 of docs/mathematics/default-route.md.
    """
    numbers, side = list(_numbers(est)), list(_side(est, now))
    taken = {p.slots[0][0] for p in (*numbers, *side) if p.slots}
    forces = [(axis, p) for axis, p in _forces(est, now) if not p.slots or p.slots[0][0] not in taken]
    group = [NUMBERS] * len(numbers) + [SIDE] * len(side) + [FORCES + axis for axis, _ in forces]
    parameters = (*numbers, *side, *(p for _, p in forces))
    return Terms(parameters, np.array(group, int), _least_side(est))


# ---- numbers of the model
def _numbers(est: Estimator) -> Iterator[Parameter]:
    """Coefficients that are not zero, and constants that the family's groups hold."""
    model, stated = est.model, _stated(est)
    own = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    sizes = {name: SHARE * abs(value) for name, value in own.items() if value != 0.0} | stated
    for name, sd in sizes.items():
        if sd > 0.0 and not (name in OWN_SIDE and "Yd" in own) and name != "X0":
            yield Parameter(f"number {name}", "1", ((est.index[name], sd),))


def _stated(est: Estimator) -> dict[str, float]:
    groups, own = stated_groups(est.model), est.model.family.split("+")
    found = [g for g in groups if (g.extension is None or g.extension in own) and g.id not in AS_CAUSE]
    held = {name for g in groups if g.id in AS_CAUSE for name in g.sd}
    return {name: sd for g in found for name, sd in g.sd.items() if name in est.index and name not in held}


# ---- asymmetry
def _side(est: Estimator, now: Innovations) -> Iterator[Parameter]:
    """Side force and yaw moment of a ship that is not symmetric; none of a response model, where a rudder offset says
    the same."""
    if not est.model.is_3dof:
        return
    own = dict(zip(est.model.coordinates, est.model.coefficients.tolist(), strict=True))
    if "Yd" in own and "Y0" in own:
        loss = _loss(est, now)
        for name in OWN_SIDE:
            size = max(np.sqrt(np.mean(loss ** (2 * name.count("u")))), 1e-3)
            weight = ASYMMETRY * abs(own[name[0] + "d"]) / size
            yield Parameter(f"side {name}", "1", ((est.index[name], weight),))
        return
    one = tuple(np.ones(d.time.size) for d in est.segments)
    for axis, force in _rudder_forces(est).items():
        series = tuple(ASYMMETRY * abs(force) / est.unit[axis] * x for x in one)
        yield Parameter(f"side {axis}", "1", series=(axis, series))


def _least_side(est: Estimator) -> float:
    """An asymmetry of the model's own is no better known than its other numbers."""
    own = dict(zip(est.model.coordinates, est.model.coefficients.tolist(), strict=True))
    if "Yd" not in own or "Y0" not in own:
        return 0.0
    return max(abs(SHARE * own[a + "0"]) / (ASYMMETRY * abs(own[a + "d"])) for a in "YN") ** 2


def _rudder_forces(est: Estimator) -> dict[int, float]:
    """Side force and yaw moment (N, N m) per rad of rudder on a straight course, by axis."""
    rows = [list(est.kernels.STATES).index(name) for name in "vr"]
    first = est.shape.first_force
    from_rudder = _rates(est, 0, 1e-3)[rows] / 1e-3
    matrix = np.stack([_rates(est, first + axis, float(est.unit[axis]))[rows] for axis in (1, 2)], axis=1)
    forces = np.linalg.solve(matrix, from_rudder)
    return {axis: float(f) * float(est.unit[axis]) for axis, f in zip((1, 2), forces, strict=True)}


def _rates(est: Estimator, entry: int, amount: float) -> np.ndarray:
    """Half the change (n,) of the states' rates between an input at `amount` and at its negative, straight course."""
    kernels, d, theta = est.kernels, est.segments[0], est.base[: est.n_theta].copy()
    x, inputs = np.zeros(len(kernels.STATES)), np.zeros(len(kernels.INPUTS))
    x[list(kernels.STATES).index("u")] = est.model.speed_m_s
    inputs[1 : 1 + d.other.shape[1]] = np.median(d.other, axis=0)
    found = []
    for sign in (1.0, -1.0):
        moved, out = inputs.copy(), np.empty(x.size)
        moved[entry] += sign * amount
        kernels.rhs(x, moved, theta, out)
        found.append(out)
    return 0.5 * (found[0] - found[1])


# ---- further forces
def _forces(est: Estimator, now: Innovations) -> Iterator[tuple[int, Parameter]]:
    """Forces by axis, each of rms one in units of its own: coefficients at zero where the family has them."""
    for axis, name, values, slot in _signals(est, now):
        size = float(np.sqrt(np.mean(values**2)))
        if not EMPTY < size < np.inf:
            continue
        if slot is not None:
            yield axis, Parameter(f"force {name}", "1", ((slot, 1.0 / size),))
            continue
        unit = values / size
        series = tuple(np.ascontiguousarray(unit[est.samples_of(i)]) for i in range(len(est.segments)))
        yield axis, Parameter(f"force {name}:{axis}", "1", series=(axis, series))


def _signals(est: Estimator, now: Innovations) -> Iterator[tuple[int, str, np.ndarray, int | None]]:
    x = {"r": now.states[:, list(est.kernels.STATES).index("r")], "d": np.clip(est.joined(lambda d: d.rudder), -1, 1)}
    if not est.model.is_3dof:
        late = _late(est, x)
        words = {w: word(w, x) for w in YAW_ONLY} | late
        for axis in range(est.n_forces):
            for name, values in words.items():
                yield axis, name, values, None
        return
    names = list(est.kernels.STATES)
    x |= {"v": now.states[:, names.index("v")], "u": _loss(est, now)}
    if "Yvvr" in est.model.coordinates and "Yrrd" in est.model.coordinates:
        length, speed = est.model.particulars.get("L", 1.0), est.model.speed_m_s
        x |= {"r": x["r"] * length / speed, "v": x["v"] / speed}
        for name in est.model.coordinates:
            if name[0] in "XYN" and name not in OWN_SIDE and name != "X0":
                yield "XYN".index(name[0]), name, word(name[1:], x), est.index[name]
        return
    for axis, own in ((0, EVEN), (1, ODD), (2, ODD)):
        for w in own:
            yield axis, w, word(w, x), None


def _late(est: Estimator, x: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What sway and speed, which a response model lacks, would do: late, cubed, fast, and as a loss of speed."""

    def of(series: np.ndarray, lag: float) -> np.ndarray:
        parts = [lagged(series[est.samples_of(i)], d.time, lag * est.clock) for i, d in enumerate(est.segments)]
        return np.concatenate(parts)

    found = {f"{a} late {lag:g}": of(x[a], lag) for a in "rd" for lag in LAGS_S}
    found |= {f"{a} late cubed": of(x[a], CUBED_LAG_S) ** 3 for a in "rd"}
    quick = of(x["r"], FAST_S)
    rates = [np.gradient(quick[est.samples_of(i)], d.time) for i, d in enumerate(est.segments)]
    slowed = of(x["r"] ** 2, SLOWED_S)
    return found | {"r fast": np.concatenate(rates)} | {f"{a} slowed": x[a] * slowed for a in "rd"}


def word(name: str, x: Mapping[str, np.ndarray]) -> np.ndarray:
    """The product (N,) that a word says: letters multiply, |a| is the size of a."""
    out, i = np.ones_like(next(iter(x.values()))), 0
    while i < len(name):
        if name[i] == "|":
            out, i = out * np.abs(x[name[i + 1]]), i + 3
        else:
            out, i = out * x[name[i]], i + 1
    return out


def _loss(est: Estimator, now: Innovations) -> np.ndarray:
    """(N,) relative change of the speed."""
    return now.states[:, list(est.kernels.STATES).index("u")] / est.model.speed_m_s - 1.0
