"""Paper 003's pipeline: extended state observer, then robust weighted LS-SVR on its estimates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Fit, FitFailed, Method
from .filtered import Rows, filtered_rows, stretches
from .ls import equation_factors, least_squares
from .ls_svr import check_svr_options, fit_of, stacked
from .observers.eso import METHODS, PRINTED_OMEGA, Observed, observe, observe_as_printed
from .regression import Differences
from .selection import free_run_cost
from .series import bridged, inputs_of, require, series_of
from .svf_ls import BLOCK_TIME, best_corner, corner_frequencies
from .svr.tuning import Tuner
from .tuning.space import Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

CORNERS = 9
SETTLED = 8.0
"""Time constants of the observer from a stretch's start that are left out."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


class EsoRwLssvr(Method):
    """Heading through an extended state observer, then `rw-ls-svr` on psi_ddot, psi_dot, rudder and its slope.

    Parameters
    ----------
    omega0 : the observer's poles, rad/s; None takes that of several whose least-squares estimate follows the training
        records best in free run ('as_printed': 45).
    aligned : give every channel the lag of the observer's last state: heading and rudder pass through the
        omega0^4/(s + omega0)^4 by which z5 is psi_dddot.  False takes the observer's states as they come.
    discretisation : 'exact' or 'euler' ('as_printed' is Euler's always).
    b0 : input gain of the observer, on the rudder; 0 leaves the whole third derivative to be observed.
    C, tuner : as in `ls-svr`.
    variant : 'corrected', or 'as_printed': b0 = 1 on the heading reference, l3 = 100, rudder and rudder slope as the
        observer has them, signed weights, regularised in SI units with intercept, fitted to the first 60 %.

    Response models, from the heading.  The printed form needs the heading reference, which it takes from the rudder
    command of a vessel with heading controller and rudder lag.  Unless aligned, the observer's derivatives lag behind
    its other states by up to 4/omega0, which biases the estimate; with the noise of any real sensor at every omega0.
    """

    name = "eso-rw-lssvr"
    title = "extended state observer and robust weighted LS-SVR (paper 003)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"omega0": Real(1e-2, 60.0, log=True), "C": Real(1e-2, 1e10, log=True)}

    def __init__(
        self,
        omega0: float | None = None,
        aligned: bool = True,
        discretisation: str = "exact",
        b0: float = 0.0,
        C: float | None = None,
        tuner: str | Tuner = "grid",
        variant: str = "corrected",
    ) -> None:
        self.omega0, self.aligned, self.discretisation, self.b0 = omega0, aligned, discretisation, b0
        self.C, self.tuner, self.variant = C, tuner, variant

    def check_options(self) -> None:
        super().check_options()
        check_svr_options(self.C, self.tuner)
        if self.discretisation not in METHODS:
            raise BadInput(f"unknown discretisation {self.discretisation!r}", hint=f"known: {', '.join(METHODS)}")
        if self.omega0 is not None and not self.omega0 > 0.0:
            raise BadInput(f"omega0 is {self.omega0!r}, a positive number of rad/s is needed")

    def regressor(self, c: float, rough: bool = False) -> Any:
        """The scikit-learn regressor at a value of C; `rough` while C is chosen."""
        from .rw_ls_svr import RwLsSvr

        return RwLsSvr(variant=self.variant).regressor(c, rough)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if model.is_3dof:
            raise CannotFit(f"the observer is one of the heading: a response model is needed, not {model.family}")
        printed = self.variant == "as_printed"
        if printed:
            omega = PRINTED_OMEGA if self.omega0 is None else self.omega0
            parts: list[Any] = [part for record in records for part in _printed(record, model, omega)]
            _check(parts, model)
        elif self.aligned:
            omega, parts = self._filtered(records, model)
        else:
            omega, parts = self._observed(records, model)
            _check(parts, model)
        first = parts[0].parts if isinstance(parts[0], Rows) else parts[0]
        spacing = float(np.median(np.diff(first.time_s)))
        samples = stacked(parts, model, max(1, int(BLOCK_TIME / omega / spacing)), physical=printed)
        return fit_of(samples, self.regressor, self.C, self.tuner, not printed, {"omega0_rad_s": omega})

    def _filtered(self, records: Sequence[Record], model: Model) -> tuple[float, list[Rows]]:
        """Poles and rows with one lag for all channels."""
        headings = [record.with_channels(yaw_rate_rad_s=None) for record in records]
        for record in headings:
            require(record, "psi")
        if self.omega0 is not None:
            return self.omega0, filtered_rows(headings, model, self.omega0)
        found = best_corner(headings, model, corner_frequencies(headings).tolist())
        return found.omega, found.rows

    def _observed(self, records: Sequence[Record], model: Model) -> tuple[float, list[Differences]]:
        """Poles and observed rows; of several poles those that follow the records best."""
        if self.omega0 is not None:
            return self.omega0, self._parts(records, model, self.omega0)
        series = [series_of(record, model) for record in records]
        best: tuple[float, float, list[Differences]] | None = None
        for omega in _poles(records):
            parts = self._parts(records, model, omega)
            try:
                _check(parts, model)
                found = least_squares(*equation_factors(parts, model)).coefficients
            except (CannotFit, FitFailed):
                continue
            cost = free_run_cost(model.with_coefficients(found), series)
            if best is None or cost < best[0]:
                best = cost, omega, parts
        if best is None:
            raise CannotFit("no observer gives enough finite rows")
        return best[1:]

    def _parts(self, records: Sequence[Record], model: Model, omega: float) -> list[Differences]:
        found = []
        for record in records:
            for piece in _stretches(record, model):
                psi, rudder, others, time, dt = _on_grid(piece, model)
                seen = observe(psi, dt, omega, self.discretisation, self.b0, rudder)
                rows = _rows(seen, rudder, np.gradient(rudder, dt), others, time, model)
                start = int(np.searchsorted(time, time[0] + SETTLED / omega))
                found.append(_cut(rows, start))
        return [rows for rows in found if len(rows.time_s)]


def _poles(records: Sequence[Record]) -> list[float]:
    dt = max(record.dt for record in records)
    length = max(record.time_s[-1] - record.time_s[0] for record in records)
    return np.geomspace(min(40.0 / length, 1.0 / dt), 1.0 / dt, CORNERS).tolist()


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


def _rows(
    seen: Observed, rudder: np.ndarray, slope: np.ndarray, others: dict[str, np.ndarray], time: np.ndarray, model: Model
) -> Differences:
    states = {"psi": seen.psi, "r": seen.r, "q": seen.psi_ddot}
    second = "q" in model.regression_states
    if unknown := [s for s in model.regression_states if s not in states]:
        raise CannotFit(f"model {model.id} has the state {unknown[0]!r}, for which records have no channel")
    inputs = {"delta": rudder, "delta_rate": slope, **others}
    x = np.column_stack([states[s] for s in model.regression_states])
    u = np.column_stack([inputs[s] for s in model.regression_inputs])
    return Differences(x, (seen.psi_dddot if second else seen.psi_ddot)[:, None].copy(), u, time)


def _cut(rows: Differences, start: int) -> Differences:
    return Differences(rows.states[start:], rows.accelerations[start:], rows.inputs[start:], rows.time_s[start:])


def _check(parts: Sequence[Differences], model: Model) -> None:
    n, p = sum(len(part.time_s) for part in parts), len(model.coordinates)
    if n <= p:
        raise CannotFit(f"{n} usable regression rows for {p} coefficients")


def _printed(record: Record, model: Model, omega: float) -> list[Differences]:
    """Rows of eq 8 as printed."""
    if model.controller is None or not model.rudder.lag_s > 0.0 or not record.has("rudder_command_rad"):
        raise CannotFit("the printed observer needs a vessel with heading controller, rudder lag and a rudder command")
    kp, found = model.controller.kp, []
    for piece in stretches(record, [require(record, "psi"), record.column("rudder_command_rad")]):
        if piece.n < SHORTEST:
            continue
        psi, _, others, time, dt = _on_grid(piece, model)
        command = piece.column("rudder_command_rad")
        reference = psi + np.interp(time, piece.time_s, bridged(command, piece.time_s)) / kp
        seen = observe_as_printed(psi, reference, dt, kp, model.rudder.lag_s, omega)
        assert seen.delta is not None and seen.delta_dot is not None
        found.append(_rows(seen, seen.delta, seen.delta_dot, others, time, model))
    return found
