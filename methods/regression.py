"""From records to the linear regression y = Phi c that least-squares methods share.

The model says which states, accelerations and inputs its regression takes (`models.simulate.regression`); here they
are formed from the channels of a record by a difference scheme:

forward
    x_dot[k] = (x[k+1] - x[k])/dt with state and input at k: exactly the difference equation of explicit Euler, so
    records made by it are recovered to rounding; a first-order approximation otherwise.
midpoint
    central pairing.  First-order equations over one step, in the mean of both ends.  Second-order equations over
    two steps, in the mean under the hat function of those steps: exact for a rudder that is linear between samples.
heading-difference
    paper 000, eq 7-11: backward differences of the heading alone, rows multiplied by dt^3 as in its eq 9, the ship
    at rest before the first sample.  Second-order response models only.
triple-integral, triple-integral-held, triple-integral-rest
    the equations integrated until a measured state is reached (`schemes_integral`), with a rudder that is linear or
    held between samples; held, and the ship at rest on heading zero at the first sample.

A missing yaw rate is differenced from the heading by the same scheme.  Steps need not be equal; a gap, or a step more
than three times the median, removes only the rows it touches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from . import factors
from .base import CannotFit
from .series import inputs_of, require, samples, steps

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

LONGEST_STEP = 3.0
"""Multiple of the median step above which a step counts as a gap."""


@dataclass(frozen=True)
class Differences:
    """What the regression of one record is evaluated at, gaps left out.

    states (N, s), accelerations (N, k) and inputs (N, i) in the order of the model's regression, SI; time_s (N,);
    `scale` multiplies the rows.
    """

    states: np.ndarray
    accelerations: np.ndarray
    inputs: np.ndarray
    time_s: np.ndarray
    scale: float = 1.0

    def blocks(self, model: Model, size: int = factors.BLOCK) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Pieces (y (n, k), phi (n, k, p)) of the regression in order, at most `size` samples each."""
        from ..models.simulate import regression

        for start in range(0, len(self.time_s), size):
            cut = slice(start, start + size)
            y, phi = regression(model, self.states[cut], self.accelerations[cut], self.inputs[cut])
            yield y * self.scale, phi * self.scale


def differences(records: Sequence[Record], model: Model, scheme: str) -> list[Differences]:
    """Differences of every record.

    Raises
    ------
    CannotFit : a record lacks a channel, the scheme does not suit the model, or all rows together are no more than
        the coefficients.
    """
    found = [difference(record, model, scheme) for record in records]
    n, p = sum(part.accelerations.size for part in found), len(model.coordinates)
    if n <= p:
        raise CannotFit(f"{n} usable regression rows for {p} coefficients")
    return found


def difference(record: Record, model: Model, scheme: str) -> Differences:
    """Differences of one record, however few; raises CannotFit as `differences` for channels and schemes."""
    return _gap_free(SCHEMES[scheme](record, model))


def _gap_free(parts: Differences) -> Differences:
    good = np.isfinite(np.column_stack([parts.states, parts.accelerations, parts.inputs])).all(axis=1)
    arrays = (np.ascontiguousarray(part[good]) for part in (parts.states, parts.accelerations, parts.inputs))
    states, accelerations, inputs = arrays
    return replace(parts, states=states, accelerations=accelerations, inputs=inputs, time_s=parts.time_s[good])


def accelerations(model: Model) -> int:
    """How many of the regression's states, from the first, have their acceleration on the left side."""
    return 3 if model.is_3dof else 1


def _second_order(model: Model) -> bool:
    return "delta_rate" in model.regression_inputs


def _usable_steps(record: Record) -> np.ndarray:
    dt = steps(record)
    return np.where(dt > LONGEST_STEP * np.median(dt), np.nan, dt)


def _ahead(values: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Forward difference (N,) of values (N,); the last is nan."""
    return np.append(np.diff(values) / dt, np.nan)


def _central(values: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Central difference (N,) of values (N,); the ends are nan."""
    inner = (values[2:] - values[:-2]) / (dt[1:] + dt[:-1])
    return np.concatenate([[np.nan], inner, [np.nan]])


def _state_columns(record: Record, model: Model, dt: np.ndarray, slope) -> dict[str, np.ndarray]:
    """Samples (N,) of the states; heading and position only enter where the model is not symmetric to them."""
    rate = samples(record, "r")
    heading = samples(record, "psi")
    if rate is None:
        rate = slope(require(record, "psi"), dt)
    columns = {"r": rate, "psi": np.zeros(record.n) if heading is None else heading}
    for symbol in model.regression_states:
        if symbol in ("u", "v"):
            columns[symbol] = require(record, symbol)
        elif symbol in ("x", "y"):
            columns[symbol] = np.zeros(record.n)
        elif symbol not in ("q", "r", "psi"):
            raise CannotFit(f"model {model.id} has the state {symbol!r}, for which records have no channel")
    return columns


def _table(columns: dict[str, np.ndarray], names: Sequence[str]) -> np.ndarray:
    return np.column_stack([columns[name] for name in names])


def _forward(record: Record, model: Model) -> Differences:
    dt = _usable_steps(record)
    states = _state_columns(record, model, dt, _ahead)
    inputs = inputs_of(record, model)
    if _second_order(model):
        states["q"] = _ahead(states["r"], dt)
        inputs["delta_rate"] = _ahead(inputs["delta"], dt)
    x = _table(states, model.regression_states)
    a = np.column_stack([_ahead(column, dt) for column in x[:, : accelerations(model)].T])
    return Differences(x, a, _table(inputs, model.regression_inputs), record.time_s)


def _midpoint(record: Record, model: Model) -> Differences:
    dt = _usable_steps(record)
    states = _state_columns(record, model, dt, _central)
    inputs = inputs_of(record, model)
    if _second_order(model):
        return _hat(record, model, dt, states, inputs)
    x, u = _table(states, model.regression_states), _table(inputs, model.regression_inputs)
    a = np.diff(x[:, : accelerations(model)], axis=0) / dt[:, None]
    time = (record.time_s[1:] + record.time_s[:-1]) / 2.0
    return Differences((x[1:] + x[:-1]) / 2.0, a, (u[1:] + u[:-1]) / 2.0, time)


def _hat(record, model, dt, states, inputs) -> Differences:
    """Second-order equations integrated with the hat function over two steps, divided by its area."""
    before, after = dt[:-1], dt[1:]
    both = before + after

    def mean(z):
        return (before * (z[:-2] + 2.0 * z[1:-1]) + after * (z[2:] + 2.0 * z[1:-1])) / (3.0 * both)

    def slope(z):
        return (z[2:] - z[:-2]) / both

    r = states["r"]
    bend = 2.0 * (np.diff(r)[1:] / after - np.diff(r)[:-1] / before) / both
    columns = {"q": slope(r), "r": mean(r), "psi": mean(states["psi"])}
    u = {name: mean(values) for name, values in inputs.items()} | {"delta_rate": slope(inputs["delta"])}
    x = _table(columns, model.regression_states)
    return Differences(x, bend[:, None], _table(u, model.regression_inputs), record.time_s[1:-1])


def _heading_difference(record: Record, model: Model) -> Differences:
    """Paper 000, eq 7-11: y(k) = psi(k) - psi(k-1), with y(0) = y(-1) = 0."""
    if not _second_order(model):
        raise CannotFit(f"the heading-difference scheme needs a second-order response model, not {model.family}")
    if not record.uniform():
        raise CannotFit(f"record {record.name}: the heading-difference scheme needs equal time steps")
    h = float(steps(record)[0])
    psi, delta = require(record, "psi"), inputs_of(record, model)["delta"]
    y = np.concatenate([[0.0, 0.0], np.diff(psi)])
    y0, y1, y2 = y[2:], y[1:-1], y[:-2]
    columns = {"q": (y0 - y1) / h**2, "r": y0 / h, "psi": psi[1:]}
    inputs = {"delta": delta[1:], "delta_rate": np.diff(delta) / h}
    x = _table(columns, model.regression_states)
    a = (y0 - 2.0 * y1 + y2)[:, None] / h**3
    return Differences(x, a, _table(inputs, model.regression_inputs), record.time_s[1:], scale=h**3)


def _integrated(which: str) -> Callable[[Record, Model], Differences]:
    def scheme(record: Record, model: Model) -> Differences:
        from . import schemes_integral

        return getattr(schemes_integral, which)(record, model)

    return scheme


SCHEMES: dict[str, Callable[[Record, Model], Differences]] = {
    "forward": _forward,
    "midpoint": _midpoint,
    "heading-difference": _heading_difference,
    "triple-integral": _integrated("triple_integral"),
    "triple-integral-held": _integrated("triple_integral_held"),
    "triple-integral-rest": _integrated("triple_integral_rest"),
}
