"""Paper 003's pipeline: extended state observer, then robust weighted LS-SVR on its estimates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..datasets.signals import bridged
from ..estimation.methods_only.observers.eso import METHODS, PRINTED_OMEGA, Observed, observe, observe_as_printed
from ..estimation.methods_only.tuning.space import Real
from ..estimation.records.series import inputs_of, require, series_of
from ..estimation.regression.filtered import BLOCK_TIME, best_corner, corner_frequencies, filtered_rows, stretches
from ..estimation.regression.least_squares import equation_factors, least_squares
from ..estimation.regression.samples import RegressionSamples, check_enough_rows
from ..estimation.results.fit import Fit
from ..estimation.simulation.selection import free_run_cost
from ..models.errors import CannotFit, FitFailed
from ..models.model import Model
from .base import method
from .ls_svr import CONSTANT, TUNER, Tuner, fit_svr, stacked_rows
from .options import POSITIVE, option, words


@method(
    "eso-rw-lssvr",
    "extended state observer and robust weighted LS-SVR (paper 003)",
    variants=("corrected", "proposed", "as_printed"),
)
def EsoRwLssvr(
    records: Sequence[Record],
    model: Model,
    omega0: float | None = option(
        None,
        "the observer's poles, rad/s; None takes those, of several, whose least-squares estimate follows the training "
        "records best in free run ('as_printed': 45)",
        POSITIVE,
        Real(1e-2, 60.0, log=True),
    ),
    aligned: bool = option(
        True,
        "give every channel the lag of the observer's last state: heading and rudder pass through the filter "
        "omega0^4/(s + omega0)^4 by which z5 estimates psi_dddot.  False takes the observer's states as they are",
    ),
    discretisation: str = option(
        "exact", "'exact' or 'euler' ('as_printed' is always Euler)", words("discretisation", METHODS)
    ),
    b0: float = option(
        0.0, "input gain of the observer, on the rudder; 0 leaves the whole third derivative to be observed"
    ),
    C: float | None = CONSTANT,
    tuner: str | Tuner = TUNER,
    weighted: bool = option(True, "False takes `ls-svr` behind the observer, with which paper 003 compares its own"),
    variant: str = option(
        "corrected",
        "'corrected'; 'proposed': what the paper proposes in corrected equations, with the observer's states as they "
        "are and C by its bee colony, whatever `aligned` and `tuner` say; or 'as_printed': b0 = 1 on the heading "
        "reference, l3 = 100, rudder and rudder slope as the observer has them, signed weights, regularised in SI "
        "units with intercept, fitted to the first 60 %",
    ),
) -> Fit:
    """Heading through an extended state observer, then `rw-ls-svr` on psi_ddot, psi_dot, rudder and its slope.

    Response models, from the heading.  The printed form needs the heading reference, which it takes from the rudder
    command of a vessel with heading controller and rudder lag.  Unless aligned, the observer's derivatives lag behind
    its other states by up to 4/omega0, which biases the estimate; with the noise of any real sensor it does so at
    every omega0.
    """
    if model.is_3dof:
        raise CannotFit(f"the heading observer needs a response model, and {model.family} is none")
    printed, proposed = variant == "as_printed", variant == "proposed"
    if printed:
        omega = PRINTED_OMEGA if omega0 is None else omega0
        parts = printed_samples(records, model, omega)
    elif aligned and not proposed:
        omega, parts = _aligned_rows(records, model, omega0)
    else:
        omega, parts = observed_samples(records, model, omega0, discretisation, b0)
    spacing = float(np.median(np.diff(parts[0].time_s)))
    rows = stacked_rows(parts, model, max(1, int(BLOCK_TIME / omega / spacing)), physical=printed)
    return fit_svr(rows, weighted, printed, C, "abc" if proposed else tuner, {"omega0_rad_s": omega})


def _aligned_rows(
    records: Sequence[Record], model: Model, omega0: float | None
) -> tuple[float, list[RegressionSamples]]:
    """Poles [rad/s] and rows in which all channels have the same lag, from the heading alone."""
    headings = [record.with_channels(yaw_rate_rad_s=None) for record in records]
    for record in headings:
        require(record, "psi")
    if omega0 is not None:
        return omega0, filtered_rows(headings, model, omega0)
    found = best_corner(headings, model)
    return found.omega, found.rows


POLES, SLOWEST = 9, 40.0
"""Poles of the observer tried, and time constants of the slowest one in the longest record."""
TRANSIENT = 8.0
"""Time constants of the observer, from the start of a stretch, that are left out."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


def observed_samples(
    records: Sequence[Record], model: Model, omega0: float | None, discretisation: str = "exact", b0: float = 0.0
) -> tuple[float, list[RegressionSamples]]:
    """Poles omega0 [rad/s] and samples of an observer with input gain b0 on the rudder; None takes those poles whose
    free run follows the records best."""
    if omega0 is not None:
        return omega0, _checked(_observed(records, model, omega0, discretisation, b0), model)
    series = [series_of(record, model) for record in records]
    best: tuple[float, float, list[RegressionSamples]] | None = None
    for omega in corner_frequencies(records, POLES, SLOWEST).tolist():
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
    """Observed samples of eq 8 as printed, with poles omega0 [rad/s]."""
    return _checked([samples for record in records for samples in _printed(record, model, omega0)], model)


def _checked(samples: list[RegressionSamples], model: Model) -> list[RegressionSamples]:
    check_enough_rows(sum(len(part.time_s) for part in samples), model)
    return samples


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
            found.append(samples.at(slice(int(np.searchsorted(time, time[0] + TRANSIENT / omega0)), None)))
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
    slopes = {"r": observed.psi_ddot, "q": observed.psi_dddot}
    return RegressionSamples.of(model, states, slopes, {"delta": rudder, "delta_rate": slope, **others}, time)


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
