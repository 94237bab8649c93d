"""Paper 003's pipeline: extended state observer, then robust weighted LS-SVR on its estimates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.observers.eso import METHODS, PRINTED_OMEGA
from ..estimation.methods_only.regression.observed import observed_samples, printed_samples
from ..estimation.methods_only.svr.regression import fit_svr, ls_svr, rw_ls_svr, stacked_rows
from ..estimation.methods_only.svr.tuning import Tuner
from ..estimation.methods_only.tuning.space import Real
from ..estimation.records.series import require
from ..estimation.regression.filtered import filtered_rows
from ..estimation.regression.filtered_fit import BLOCK_TIME, best_corner
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit
from ..models.model import Model
from .base import Method
from .ls_svr import CONSTANT, TUNER
from .options import POSITIVE, option, words


class EsoRwLssvr(Method):
    """Heading through an extended state observer, then `rw-ls-svr` on psi_ddot, psi_dot, rudder and its slope.

    Response models, from the heading.  The printed form needs the heading reference, which it takes from the rudder
    command of a vessel with heading controller and rudder lag.  Unless aligned, the observer's derivatives lag behind
    its other states by up to 4/omega0, which biases the estimate; with the noise of any real sensor it does so at
    every omega0.
    """

    name = "eso-rw-lssvr"
    title = "extended state observer and robust weighted LS-SVR (paper 003)"
    variants = ("corrected", "proposed", "as_printed")
    omega0: float | None = option(
        None,
        "the observer's poles, rad/s; None takes those, of several, whose least-squares estimate follows the training "
        "records best in free run ('as_printed': 45)",
        POSITIVE,
        Real(1e-2, 60.0, log=True),
    )
    aligned: bool = option(
        True,
        "give every channel the lag of the observer's last state: heading and rudder pass through the filter "
        "omega0^4/(s + omega0)^4 by which z5 estimates psi_dddot.  False takes the observer's states as they are",
    )
    discretisation: str = option(
        "exact", "'exact' or 'euler' ('as_printed' is always Euler)", words("discretisation", METHODS)
    )
    b0: float = option(
        0.0, "input gain of the observer, on the rudder; 0 leaves the whole third derivative to be observed"
    )
    C: float | None = CONSTANT
    tuner: str | Tuner = TUNER
    weighted: bool = option(True, "False takes `ls-svr` behind the observer, with which paper 003 compares its own")
    variant: str = option(
        "corrected",
        "'corrected'; 'proposed': what the paper proposes in corrected equations, with the observer's states as they "
        "are and C by its bee colony, whatever `aligned` and `tuner` say; or 'as_printed': b0 = 1 on the heading "
        "reference, l3 = 100, rudder and rudder slope as the observer has them, signed weights, regularised in SI "
        "units with intercept, fitted to the first 60 %",
    )

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if model.is_3dof:
            raise CannotFit(f"the heading observer needs a response model, and {model.family} is none")
        printed, proposed = self.variant == "as_printed", self.variant == "proposed"
        parts: Sequence[Any]
        if printed:
            omega = PRINTED_OMEGA if self.omega0 is None else self.omega0
            parts = samples = printed_samples(records, model, omega)
        elif self.aligned and not proposed:
            omega, parts = _aligned_rows(records, model, self.omega0)
            samples = [rows.parts for rows in parts]
        else:
            omega, samples = observed_samples(records, model, self.omega0, self.discretisation, self.b0)
            parts = samples
        spacing = float(np.median(np.diff(samples[0].time_s)))
        rows = stacked_rows(parts, model, max(1, int(BLOCK_TIME / omega / spacing)), physical=printed)
        extra = {"omega0_rad_s": omega}
        regressor = (rw_ls_svr if self.weighted else ls_svr)("as_printed" if printed else "corrected")
        tuner = "abc" if proposed else self.tuner
        return fit_svr(rows, regressor, self.C, tuner, not printed, extra)


def _aligned_rows(records: Sequence[Record], model: Model, omega0: float | None) -> tuple[float, Sequence[Any]]:
    """Poles [rad/s] and rows in which all channels have the same lag, from the heading alone."""
    headings = [record.with_channels(yaw_rate_rad_s=None) for record in records]
    for record in headings:
        require(record, "psi")
    if omega0 is not None:
        return omega0, filtered_rows(headings, model, omega0)
    found = best_corner(headings, model)
    return found.omega, found.rows
