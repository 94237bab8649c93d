"""Integral schemes: the regression of the integrated equations of motion.

No channel is differenced.  The equation of motion is integrated until a measured state stands on its left side:
three times from the heading for a second-order response model, twice for a first-order one, one time less from the
yaw rate alone, once for a 3-DOF model.  The unknown initial conditions are a polynomial in time of that many terms,
which is projected out of every stretch without a gap.  White noise on the measured state stays white on the left side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit
from ...models.model import Model
from ..numerics import factors
from ..records.series import inputs_of, require, samples, steps, yaw_rate_of
from .samples import LONGEST_STEP, RegressionSamples, n_accelerations, table

EXTRA_SAMPLES = 5
"""Samples that a stretch needs in addition to the terms of its polynomial."""
HELD, LINEAR = (1.0, 0.5, 1.0 / 6.0), (0.5, 1.0 / 3.0, 1.0 / 8.0)
"""Weight, in dt^m, of the step's first sample in the m-fold integral over one step; the second has the rest of 1/m!."""


@dataclass(frozen=True)
class EvaluatedRegression(RegressionSamples):
    """A regression that is already evaluated: accelerations is y (N, k), states is phi (N, k p), inputs (N, 0)."""

    def blocks(self, model: Model, size: int = factors.BLOCK) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """As `RegressionSamples.blocks`."""
        for start in range(0, len(self.time_s), size):
            y = self.accelerations[start : start + size]
            phi = self.states[start : start + size]
            yield y * self.scale, phi.reshape(len(y), y.shape[1], -1) * self.scale


class Roles(NamedTuple):
    """Which coefficient of a response model multiplies which variable."""

    linear: dict[str, tuple[int, float]]
    """Symbol (q, r, delta, delta_rate) -> index of the coefficient and factor of the variable."""
    others: list[int]
    """Indices of the coefficients of functions of the yaw rate."""

    @property
    def order(self) -> int:
        """Order of the model in the yaw rate."""
        return 2 if "delta_rate" in self.linear else 1


def roles(model: Model) -> Roles:
    """Roles of a response model's coefficients, found by evaluating its regression at unit arguments.

    Raises
    ------
    CannotFit : for a 3-DOF model, or for one in which anything but functions of the yaw rate is not linear.
    """
    from ...models.simulate import regression

    names = [*model.regression_states, *model.regression_inputs]
    linear, taken = {}, set()
    if model.is_3dof or not {"r", "psi", "delta"} <= set(names) <= {"q", "r", "psi", "delta", "delta_rate"}:
        raise CannotFit(f"model {model.id} is no response model with the rudder as its only input")
    split = len(model.regression_states)
    for symbol in ("q", "r", "delta", "delta_rate"):
        if symbol not in names:
            continue
        points = np.outer([1.0, 2.0], np.eye(len(names))[names.index(symbol)])
        phi = regression(model, points[:, :split], np.zeros((2, 1)), points[:, split:])[1][:, 0]
        proportional = np.flatnonzero((phi[0] != 0.0) & (np.abs(phi[1] - 2.0 * phi[0]) < 1e-12))
        if len(proportional) > 1 or (symbol == "delta" and not len(proportional)):
            raise CannotFit(f"model {model.id} is not linear in {symbol}")
        for i in proportional.tolist():
            linear[symbol] = (i, float(phi[0, i]))
            taken.add(i)
    return Roles(linear, [i for i in range(len(model.coordinates)) if i not in taken])


def integral(values: np.ndarray, slope: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Running integral (N, ...) of smooth values with slopes (N, ...) over steps dt (N - 1,): cubic Hermite."""
    dt = dt.reshape(-1, *([1] * (values.ndim - 1)))
    pieces = dt / 2.0 * (values[1:] + values[:-1]) + dt**2 / 12.0 * (slope[:-1] - slope[1:])
    return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(pieces, axis=0)])


def rudder_integrals(rudder: np.ndarray, dt: np.ndarray, held: bool) -> list[np.ndarray]:
    """Onefold, twofold and threefold running integrals (N,) of a rudder (N,) that is held or linear between samples.

    Exact for that rudder.
    """
    found: list[np.ndarray] = []
    for m, (share, whole) in enumerate(zip(HELD if held else LINEAR, (1.0, 0.5, 1.0 / 6.0), strict=True), 1):
        piece = dt**m * (share * rudder[:-1] + (whole - share) * rudder[1:])
        for j, lower in enumerate(reversed(found), 1):
            piece = piece + dt**j / (1.0, 2.0)[j - 1] * lower[:-1]
        found.append(np.concatenate([[0.0], np.cumsum(piece)]))
    return found


def triple_integral(record: Record, model: Model, held: bool = False, rest: bool = False) -> RegressionSamples:
    """The integrated regression of a record; the rudder is taken as linear between samples, or as `held`.

    With `rest` the ship is on a straight course of heading zero at the first sample, so no polynomial is needed: the
    protocol of paper 000, for response models.

    Raises
    ------
    CannotFit : a channel is missing, the model is neither 3-DOF nor a response model, or no stretch is long enough.
    """
    if rest and model.is_3dof:
        raise CannotFit(f"the triple-integral-rest scheme needs a response model, not {model.family}")
    channels = _channels_3dof(record, model) if model.is_3dof else _channels_response(record, model)
    order = 1 if model.is_3dof else roles(model).order + ("psi" in channels)
    found = []
    for stretch in _stretches(record, channels, order):
        time = record.time_s[stretch]
        part = {name: values[stretch] for name, values in channels.items()}
        y, phi = _rows_3dof(part, time, model) if model.is_3dof else _rows_response(part, time, model, order, held)
        rows = np.column_stack([y, phi])
        if not rest:
            rows = _without_polynomial(rows, time, order)
        found.append((rows[:, : y.shape[1]], rows[:, y.shape[1] :], time))
    if not found:
        raise CannotFit(f"record {record.name} has no stretch without gaps that is long enough to integrate")
    y, phi, time = (np.concatenate([part[i] for part in found]) for i in range(3))
    return EvaluatedRegression(phi, y, np.zeros((len(y), 0)), time)


def _channels_response(record: Record, model: Model) -> dict[str, np.ndarray]:
    """Channels (N,) that the integrals of a response model take: heading if there is one, yaw rate, rudder."""
    heading, delta = samples(record, "psi"), inputs_of(record, model)["delta"]
    if heading is None:
        return {"r": require(record, "r"), "delta": delta}
    return {"psi": heading, "r": yaw_rate_of(record), "delta": delta}


def _channels_3dof(record: Record, model: Model) -> dict[str, np.ndarray]:
    """Channels (N,) that the integrals of a 3-DOF model take."""
    rate = samples(record, "r")
    if rate is None:
        heading = require(record, "psi")
        rate = np.gradient(heading, record.time_s)
    heading = samples(record, "psi")
    states = {"r": rate, "psi": np.zeros(record.n) if heading is None else heading}
    for symbol in model.regression_states:
        if symbol not in states:
            states[symbol] = np.zeros(record.n) if symbol in ("x", "y") else require(record, symbol)
    return states | inputs_of(record, model)


def _stretches(record: Record, channels: dict[str, np.ndarray], order: int) -> Iterator[np.ndarray]:
    """Indices of consecutive samples without gaps; a step above `LONGEST_STEP` medians ends a stretch."""
    known = np.flatnonzero(np.isfinite(np.column_stack(list(channels.values()))).all(axis=1))
    if not known.size:
        return
    limit = LONGEST_STEP * np.median(steps(record)) * (1.0 + 1e-6)
    breaks = np.flatnonzero(np.diff(record.time_s[known]) > limit) + 1
    for stretch in np.split(known, breaks):
        if stretch.size >= order + EXTRA_SAMPLES:
            yield stretch


def _rows_response(
    part: dict[str, np.ndarray], time: np.ndarray, model: Model, order: int, held: bool
) -> tuple[np.ndarray, np.ndarray]:
    """y (N, 1) and phi (N, p) of a response model, integrated `order` times over one stretch."""
    from ...models.simulate import regression

    role, dt = roles(model), np.diff(time)
    base = part["psi"] if "psi" in part else part["r"]
    first = integral(base, np.gradient(base, time, edge_order=2), dt)
    levels = [first, integral(first, base, dt)]
    rudder = rudder_integrals(part["delta"], dt, held)
    columns = {"q": levels[0], "r": levels[role.order - 1], "delta": rudder[order - 1]}
    if order > 1:
        columns["delta_rate"] = rudder[order - 2]
    phi = np.zeros((len(time), len(model.coordinates)))
    for symbol, (i, factor) in role.linear.items():
        phi[:, i] = factor * columns[symbol]
    if role.others:
        states = np.zeros((len(time), len(model.regression_states)))
        states[:, model.regression_states.index("r")] = part["r"]
        inputs = np.zeros((len(time), len(model.regression_inputs)))
        other = regression(model, states, np.zeros((len(time), 1)), inputs)[1][:, 0, role.others]
        slope = np.gradient(other, time, axis=0, edge_order=2)
        for _ in range(order):
            other, slope = integral(other, slope, dt), other
        phi[:, role.others] = other
    return base[:, None], phi


def _rows_3dof(part: dict[str, np.ndarray], time: np.ndarray, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """y (N, k) and phi (N, k p) of a 3-DOF model, integrated once over one stretch.

    The left side is linear in the accelerations, y = M a + y0, so its integral is M x plus the integral of y0.
    """
    from ...models.simulate import regression

    x, u = table(part, model.regression_states), table(part, model.regression_inputs)
    k, dt = n_accelerations(model), np.diff(time)
    at_rest, phi = regression(model, x, np.zeros((len(x), k)), u)
    mass = mass_matrices(model, x[:1], u[:1])[0]
    flat = np.column_stack([at_rest, phi.reshape(len(x), -1)])
    flat = integral(flat, np.gradient(flat, time, axis=0, edge_order=2), dt)
    return x[:, :k] @ mass.T + flat[:, :k], flat[:, k:]


def mass_matrices(model: Model, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """M (N, k, k) of the left side y = M a + y0 at regression states x (N, s) and inputs u (N, i).

    Raises
    ------
    CannotFit : the regressors hold accelerations.
    """
    from ...models.simulate import regression

    k = n_accelerations(model)
    at_rest, phi = regression(model, x, np.zeros((len(x), k)), u)
    columns = []
    for unit in np.eye(k):
        y, accelerated = regression(model, x, np.tile(unit, (len(x), 1)), u)
        if not np.array_equal(accelerated, phi):
            raise CannotFit(f"model {model.id} has accelerations among its regressors")
        columns.append(y - at_rest)
    return np.stack(columns, axis=2)


def _without_polynomial(rows: np.ndarray, time: np.ndarray, terms: int) -> np.ndarray:
    """rows (N, m) minus their least-squares polynomials of `terms` terms in time."""
    place = 2.0 * (time - time[0]) / np.ptp(time) - 1.0
    basis = np.linalg.qr(np.polynomial.legendre.legvander(place, terms - 1))[0]
    return rows - basis @ (basis.T @ rows)
