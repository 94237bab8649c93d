"""Rows of a response model's regression from the heading through an extended state observer (paper 003)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....datasets.record import Record
from ....datasets.signals import bridged
from ....models.errors import CannotFit, FitFailed
from ....models.model import Model
from ...records.series import inputs_of, require, series_of
from ...regression.filtered import stretches
from ...regression.least_squares import equation_factors, least_squares
from ...regression.samples import RegressionSamples, check_enough_rows, table
from ...simulation.selection import free_run_cost
from ..observers.eso import Observed, observe, observe_as_printed

POLES = 9
"""Poles of the observer tried."""
TRANSIENT = 8.0
"""Time constants of the observer, from the start of a stretch, that are left out."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


def observed_samples(
    records: Sequence[Record], model: Model, omega0: float | None, discretisation: str = "exact", b0: float = 0.0
) -> tuple[float, list[RegressionSamples]]:
    """Poles omega0 [rad/s] and observed samples; None takes those whose free run follows the records best.

    Parameters
    ----------
    discretisation : of the observer, 'exact' or 'euler'.
    b0 : its input gain on the rudder.

    Raises
    ------
    CannotFit : a record lacks a channel, or no observer gives enough finite rows.
    """
    if omega0 is not None:
        return omega0, _checked(_observed(records, model, omega0, discretisation, b0), model)
    series = [series_of(record, model) for record in records]
    best: tuple[float, float, list[RegressionSamples]] | None = None
    for omega in _poles(records):
        samples = _observed(records, model, omega, discretisation, b0)
        try:
            _checked(samples, model)
            coefficients = least_squares(*equation_factors(samples, model)).coefficients
        except (CannotFit, FitFailed):
            continue
        cost = free_run_cost(model.with_coefficients(coefficients), series)
        if best is None or cost < best[0]:
            best = cost, omega, samples
    if best is None:
        raise CannotFit("no observer gives enough finite rows")
    return best[1:]


def printed_samples(records: Sequence[Record], model: Model, omega0: float) -> list[RegressionSamples]:
    """Observed samples of eq 8 as printed, with poles omega0 [rad/s].

    Raises
    ------
    CannotFit : the vessel has no heading controller or rudder lag, a record has no rudder command or heading, or there
        are no more rows than coefficients.
    """
    return _checked([samples for record in records for samples in _printed(record, model, omega0)], model)


def _checked(samples: list[RegressionSamples], model: Model) -> list[RegressionSamples]:
    check_enough_rows(sum(len(part.time_s) for part in samples), model)
    return samples


def _poles(records: Sequence[Record]) -> list[float]:
    """Poles tried, rad/s: from the slowest that the longest record allows to the sampling rate."""
    dt = max(record.dt for record in records)
    length = max(record.time_s[-1] - record.time_s[0] for record in records)
    return np.geomspace(min(40.0 / length, 1.0 / dt), 1.0 / dt, POLES).tolist()


def _observed(
    records: Sequence[Record], model: Model, omega0: float, discretisation: str, b0: float
) -> list[RegressionSamples]:
    """Samples of every stretch after the observer's transient."""
    found = []
    for record in records:
        for piece in _stretches(record, model):
            psi, rudder, others, time, dt = _on_grid(piece, model)
            states = observe(psi, dt, omega0, discretisation, b0, rudder)
            samples = _samples(states, rudder, np.gradient(rudder, dt), others, time, model)
            found.append(_from(samples, int(np.searchsorted(time, time[0] + TRANSIENT / omega0))))
    return [samples for samples in found if len(samples.time_s)]


def _stretches(record: Record, model: Model) -> list[Record]:
    used = [require(record, "psi"), *inputs_of(record, model).values()]
    return [piece for piece in stretches(record, used) if piece.n >= SHORTEST]


def _on_grid(record: Record, model: Model) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], np.ndarray, float]:
    """Heading, rudder, other inputs and times (N,) at equal steps dt."""
    time, dt = record.time_s, record.dt
    grid = time if record.uniform() else np.arange(time[0], time[-1] + 0.5 * dt, dt)
    given = {k: np.interp(grid, time, bridged(v, time)) for k, v in inputs_of(record, model).items()}
    psi = np.interp(grid, time, bridged(require(record, "psi"), time))
    return psi, given.pop("delta"), given, grid, dt


def _samples(
    observed: Observed,
    rudder: np.ndarray,
    slope: np.ndarray,
    others: dict[str, np.ndarray],
    time: np.ndarray,
    model: Model,
) -> RegressionSamples:
    states = {"psi": observed.psi, "r": observed.r, "q": observed.psi_ddot}
    if unknown := [s for s in model.regression_states if s not in states]:
        raise CannotFit(f"model {model.id} has the state {unknown[0]!r}, for which records have no channel")
    acceleration = observed.psi_dddot if "q" in model.regression_states else observed.psi_ddot
    inputs = {"delta": rudder, "delta_rate": slope, **others}
    x, u = table(states, model.regression_states), table(inputs, model.regression_inputs)
    return RegressionSamples(x, acceleration[:, None].copy(), u, time)


def _from(samples: RegressionSamples, start: int) -> RegressionSamples:
    states, accelerations, inputs = (a[start:] for a in (samples.states, samples.accelerations, samples.inputs))
    return RegressionSamples(states, accelerations, inputs, samples.time_s[start:])


def _printed(record: Record, model: Model, omega0: float) -> list[RegressionSamples]:
    if model.controller is None or not model.rudder.lag_s > 0.0 or not record.has("rudder_command_rad"):
        raise CannotFit("the printed observer needs a vessel with heading controller, rudder lag and a rudder command")
    kp, found = model.controller.kp, []
    for piece in stretches(record, [require(record, "psi"), record.column("rudder_command_rad")]):
        if piece.n < SHORTEST:
            continue
        psi, _, others, time, dt = _on_grid(piece, model)
        command = piece.column("rudder_command_rad")
        reference = psi + np.interp(time, piece.time_s, bridged(command, piece.time_s)) / kp
        observed = observe_as_printed(psi, reference, dt, kp, model.rudder.lag_s, omega0)
        assert observed.delta is not None and observed.delta_dot is not None
        found.append(_samples(observed, observed.delta, observed.delta_dot, others, time, model))
    return found
