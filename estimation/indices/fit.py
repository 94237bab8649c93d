"""The fit of a model to manoeuvring indices: bounded least squares with a prior, and what the indices determine.

With the indices y_i, their standard deviations s_i, the indices f_i of the model and the parameters z in standard
deviations of the prior,

    minimise  sum ((f_i(z) - y_i) / s_i)^2 + z^T z

from several points.  With the Jacobian J of the first residuals, the covariance of z is (J^T J / c + I)^-1, where c is
the larger of 1 and the first sum over its degrees of freedom, n - trace(I - (J^T J + I)^-1) (Birge 1932): where the
family cannot give all indices, intervals are wider.  A parameter whose standard deviation stays above half of the
prior's is not determined.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...datasets.generator import channels_of
from ...datasets.indices import indices
from ...datasets.manoeuvres import parse_manoeuvre
from ...models import kernels
from ...models.errors import FitFailed
from ...models.lanes import closed_loops, width
from ...models.model import Model
from ..estimates.assessment import NORMAL_95
from .given import NAMES, OF_KIND, GivenIndex, GivenShip, units_of
from .result import IndexRow, ModelFromIndices, ParameterRow

FAMILY = "turning-response"
STEPS = 60
"""Samples in the time L/U."""
LENGTHS = {"turn": 50, "zigzag": 35}
"""Times L/U that a manoeuvre takes: about 540 degrees of a turn, and two overshoots."""
Array = NDArray[np.float64]


def model_of(ship: GivenShip, parameters: Mapping[str, float]) -> Model:
    """The ship as a model with these published parameters."""
    known = kernels.load(FAMILY)
    clock = ship.length_m / ship.speed_m_s
    blank = Model(
        id=ship.name,
        family=FAMILY,
        coefficients=np.full(len(known.COEFFICIENTS), np.nan),
        constants=np.array([ship.length_m, ship.speed_m_s]),
        title=f"{ship.name}, from manoeuvring indices",
        source="manoeuvring indices",
        speed_m_s=ship.speed_m_s,
        max_step_s=clock / STEPS,
        rudder=ship.gear,
        particulars={"L": ship.length_m},
    )
    return blank.with_coefficients(blank.from_parameters(parameters))


def predicted(model: Model, parameters: Array, wanted: Iterable[tuple[str, str]]) -> Array:
    """Indices (B, k), SI units, of parameter sets (B, q) for k pairs of manoeuvre and index; nan where not reached."""
    pairs, clock = list(wanted), model.particulars["L"] / model.speed_m_s
    dt, sets = clock / STEPS, np.array([model.from_parameters(row) for row in parameters])
    found: dict[tuple[str, str], Array] = {}
    for text in dict.fromkeys(text for text, _ in pairs):
        names = [name for own, name in pairs if own == text]
        parts = [
            _of_block(model, sets[first : first + width(model)], text, names, dt)
            for first in range(0, len(sets), width(model))
        ]
        found |= {(text, name): np.concatenate([part[name] for part in parts]) for name in names}
    return np.column_stack([found[pair] for pair in pairs])


def _of_block(model: Model, sets: Array, text: str, names: list[str], dt: float) -> dict[str, Array]:
    manoeuvre = parse_manoeuvre(text)
    control = manoeuvre.control(model, dt, LENGTHS[manoeuvre.kind] * STEPS * dt, np.random.default_rng(0))
    with np.errstate(all="ignore"):
        run = closed_loops(model, dt, [control] * len(sets), sets)
        channels = channels_of(model, run.states, run.command_rad, run.rudder_rad)
        return indices(names, dt * np.arange(run.states.shape[1]), channels)


Array = NDArray[np.float64]


class Prior(NamedTuple):
    """Mean and standard deviation of a parameter, of its logarithm or of its logit."""

    scale: str
    mean: float
    sd: float


PRIORS = {
    "damping": Prior("plain", 0.5, 0.6),
    "gain": Prior("log", math.log(0.8), 0.5),
    "race": Prior("logit", -0.85, 1.0),
    "cubic": Prior("log", math.log(2.0), 1.5),
    "pivot": Prior("log", math.log(0.38), 0.25),
    "surge": Prior("log", math.log(0.05), 0.5),
    "speed_loss": Prior("log", math.log(8.0), 0.4),
}
"""Assumptions of this project, wide enough for the published ships."""
NAMES_OF = tuple(PRIORS)
FARTHEST = 5.0
"""Bound of a parameter, in standard deviations of its prior."""
DRAWS, STARTS = 64, 2
"""Points of the prior at which the misfit is computed, and the best of them from which a search starts."""
STEP = 0.02
NOT_REACHED = 20.0
"""Residual of an index that a run does not reach."""
DETERMINED = 0.5
"""Largest standard deviation of a parameter that is determined, in those of its prior."""
STANDARD = (
    ("turn:35", "advance_m"),
    ("turn:35", "transfer_m"),
    ("turn:35", "tactical_diameter_m"),
    ("turn:35", "speed_ratio"),
    ("zigzag:10/10", "first_overshoot_deg"),
    ("zigzag:10/10", "second_overshoot_deg"),
    ("zigzag:10/10", "initial_turning_m"),
    ("zigzag:20/20", "first_overshoot_deg"),
)
"""Indices of IMO MSC.137(76), which are predicted where they are not given."""


def parameters_of(z: Array) -> Array:
    """Published parameters (..., q) of z (..., q)."""
    raw = z * np.array([p.sd for p in PRIORS.values()]) + np.array([p.mean for p in PRIORS.values()])
    out = raw.copy()
    for i, prior in enumerate(PRIORS.values()):
        if prior.scale == "log":
            out[..., i] = np.exp(raw[..., i])
        elif prior.scale == "logit":
            out[..., i] = 1.0 / (1.0 + np.exp(-raw[..., i]))
    return out


class IndicesFit:
    """Residuals and Jacobian of the fit for z (q,).

    rows : the given indices;  others : further ones, which are predicted.
    """

    def __init__(self, ship: GivenShip, others: Sequence[GivenIndex]) -> None:
        self.ship, self.rows, self.others = ship, ship.indices, tuple(others)
        self.model = model_of(ship, dict(zip(NAMES_OF, parameters_of(np.zeros(len(PRIORS))), strict=True)))
        self._last: tuple[Array, Array] | None = None
        self.value, self.sd = (np.array([getattr(row, name) for row in self.rows]) for name in ("value", "accuracy"))

    def indices(self, z: Array, rows: Sequence[GivenIndex]) -> Array:
        """Indices (B, n) in the units of the rows, of z (B, q)."""
        pairs = [(row.manoeuvre, row.name) for row in rows]
        return predicted(self.model, parameters_of(z), pairs) / np.array([row.si for row in rows])

    def misfits(self, z: Array) -> Array:
        """Differences (B, n) of z (B, q) in standard deviations of the indices."""
        found = (self.indices(z, self.rows) - self.value) / self.sd
        return np.where(np.isfinite(found), np.clip(found, -1e3, 1e3), NOT_REACHED)

    def residuals(self, z: Array) -> Array:
        """Misfits and z, (n + q,)."""
        return np.concatenate([self._at(z)[0], z])

    def jacobian(self, z: Array) -> Array:
        """Of the residuals, (n + q, q), by central differences."""
        return np.vstack([_slopes(self._at(z)[1:]), np.eye(z.size)])

    def _at(self, z: Array) -> Array:
        """Misfits (1 + 2 q, n) at z and around it, which one block of runs gives together; the last are kept."""
        if self._last is None or not np.array_equal(self._last[0], z):
            self._last = z.copy(), self.misfits(np.vstack([z, _around(z)]))
        return self._last[1]


def _around(z: Array) -> Array:
    """Points (2 q, q) a step above and below z (q,) in each parameter."""
    steps = STEP * np.eye(z.size)
    return np.concatenate([z + steps, z - steps])


def _slopes(ends: Array) -> Array:
    """Central differences (n, q) of values (2 q, n) at `_around`."""
    above, below = np.split(ends, 2)
    return (above - below).T / (2.0 * STEP)


def fit(ship: GivenShip) -> ModelFromIndices:
    """The model whose indices come nearest to those given, with intervals.

    Raises
    ------
    FitFailed : no parameters of the family come near the indices.
    """
    problem = IndicesFit(ship, _further(ship))
    z = _best(problem)
    misfit, ends = problem.misfits(z[None])[0], problem.indices(_around(z), problem.rows) / problem.sd
    slopes = np.nan_to_num(_slopes(ends))  # an index that is not reached beside z tells nothing
    information = slopes.T @ slopes
    spent = z.size - float(np.trace(np.linalg.inv(information + np.eye(z.size))))
    excess = max(1.0, float(misfit @ misfit) / max(len(misfit) - spent, 1.0))
    covariance: Array = np.asarray(np.linalg.inv(information / excess + np.eye(z.size)), dtype=np.float64)
    values = dict(zip(NAMES_OF, parameters_of(z).tolist(), strict=True))
    return ModelFromIndices(
        model=model_of(ship, values),
        parameters=(*_parameters(z, covariance), *_nomoto(z, covariance)),
        indices=_indices(problem, z, covariance),
        excess=math.sqrt(excess),
    )


def _best(problem: IndicesFit) -> Array:
    from scipy import optimize

    search: Any = optimize.least_squares
    draws = np.vstack([np.zeros(len(PRIORS)), np.random.default_rng(0).standard_normal((DRAWS - 1, len(PRIORS)))])
    costs = np.sum(problem.misfits(draws) ** 2, axis=1) + np.sum(draws**2, axis=1)
    found = [
        search(problem.residuals, draws[i], problem.jacobian, bounds=(-FARTHEST, FARTHEST), max_nfev=60)
        for i in np.argsort(costs, kind="stable")[:STARTS]
    ]
    best = min(found, key=lambda one: one.cost)
    lost = np.isnan(problem.indices(best.x[None], problem.rows)[0])
    if lost.any():
        row = problem.rows[int(lost.argmax())]
        raise FitFailed(f"no model of the family performs {row.manoeuvre} as far as its {row.key}, with the others")
    return best.x


def _further(ship: GivenShip) -> list[GivenIndex]:
    """The standard indices that are not given."""
    given = {(row.manoeuvre, row.name) for row in ship.indices}
    out: list[GivenIndex] = []
    for text, key in STANDARD:
        own = next(n for n in (*OF_KIND["turn"], *OF_KIND["zigzag"]) if key == n or key.startswith(f"{n}_"))
        name = NAMES.get(own, own)
        if (text, name) not in given and parse_manoeuvre(text).values[0] <= ship.gear.max_rad + 1e-9:
            si = units_of(own, ship.length_m, ship.speed_m_s)[key.removeprefix(own).removeprefix("_")]
            out.append(GivenIndex(text, key, name, math.nan, math.nan, si))
    return out


def _parameters(z: Array, covariance: Array) -> list[ParameterRow]:
    sd, rows = np.sqrt(np.diag(covariance)), []
    low, value, high = (parameters_of(z + side * NORMAL_95 * sd) for side in (-1.0, 0.0, 1.0))
    for i, name in enumerate(NAMES_OF):
        ends = (float(low[i]), float(high[i])) if sd[i] <= DETERMINED else None
        rows.append(ParameterRow(name, "L" if name == "pivot" else "1", float(value[i]), ends))
    return rows


def _nomoto(z: Array, covariance: Array) -> list[ParameterRow]:
    """K' and T', where the indices say that the ship is stable on a straight course."""
    damping, gain = PRIORS["damping"], PRIORS["gain"]
    sd = np.sqrt(np.diag(covariance))
    middle = damping.mean + damping.sd * float(z[0])
    if max(sd[:2]) > DETERMINED or middle - NORMAL_95 * damping.sd * sd[0] <= 0.0:
        return []
    ends = middle + NORMAL_95 * damping.sd * sd[0] * np.array([1.0, -1.0])
    slopes = np.array([-damping.sd / middle, gain.sd])
    wide = math.exp(NORMAL_95 * math.sqrt(slopes @ covariance[:2, :2] @ slopes))
    value = math.exp(gain.mean + gain.sd * float(z[1])) / middle
    shortest, longest = (1.0 / ends).tolist()
    return [
        ParameterRow("K'", "1", value, (value / wide, value * wide)),
        ParameterRow("T'", "1", 1.0 / middle, (shortest, longest)),
    ]


def _indices(problem: IndicesFit, z: Array, covariance: Array) -> tuple[IndexRow, ...]:
    rows = (*problem.rows, *problem.others)
    values, slopes = problem.indices(z[None], rows)[0], _slopes(problem.indices(_around(z), rows))
    spread = NORMAL_95 * np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    ends = np.column_stack([values, np.maximum(values - spread, 0.0), values + spread])
    return tuple(
        IndexRow(row.manoeuvre, row.key, *map(_known, (row.value, row.accuracy, *own)))
        for row, own in zip(rows, ends.tolist(), strict=True)
    )


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
