"""The diagnosis made of what was found, with the hypothesis and the noise as results tell them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...estimation.filters.innovations.vector import SYMBOLS
from ...models.model import CHANNELS as COLUMNS
from ..candidate import Unmodelled
from ..residuals.unmodelled import confirmed
from ..result import Diagnosis
from .verdict import next_manoeuvre

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ...models.model import Model
    from ..candidate import Candidate
    from ..options import Options
    from ..result import Entry, Finding
    from ..state import State


def hypothesis_of(state: State, left: Candidate | None, records: Sequence[Record]) -> dict[str, Any] | None:
    """The sparse term that fits an unexplained effect best, and whether held-out records confirm it."""
    if left is None:
        return None
    est = state.est
    axes = ("X", "Y", "N") if est.n_forces == 3 else ("N", "N rate")
    terms = []
    for p in left.variant:
        if p.series is not None:
            axis = p.series[0]
            where = axes[axis] if axis < est.n_forces else f"channel {COLUMNS[SYMBOLS[axis - est.n_forces]]}"
            name = p.name.rpartition(":")[0]
            terms.append({"term": name, "acts_on": where, "size": est.value(left.setting, p)})
    return {
        "hypothesis": left.cause.label if isinstance(left.cause, Unmodelled) else left.cause.id,
        "terms": terms,
        "log_p": left.log_p,
        "confirmed_on_held_out": confirmed(state, left, records) if left.variant and records else None,
    }


def noise_of(est: Estimator, s: Setting) -> dict[str, Any]:
    """Estimated noise: sensors by column, forces in N and N m, correlation time, rudder sensor."""
    names = [COLUMNS[symbol] for symbol in SYMBOLS]
    return {
        "sensor_sd": {names[c]: float(s.noise.sensor_sd[c]) for c in np.flatnonzero(est.channels)},
        "force_sd": (s.noise.force_sd * est.unit).tolist(),
        "correlation_time_s": float(s.noise.correlation_time_s),
        "rudder_sd": est.rudder_sd,
    }


def diagnosis_of(
    models: tuple[Model, Model],
    options: Options,
    decided: tuple[str, str],
    findings: Sequence[Finding],
    bank: Sequence[Entry],
    *,
    noise: Mapping[str, Any],
    poor: str | None = None,
    hypothesis: dict[str, Any] | None = None,
    doubts: tuple[str, ...] = (),
) -> Diagnosis:
    """The diagnosis without the names of its records, its gain (`gain.runs`) and its cost, which `diagnose` knows.

    models : base and extended.  decided : verdict and reason.  poor : why the records cannot decide anything; then no
    cause is told.
    """
    return Diagnosis(
        *models,
        base_parameters=str(options.base_parameters),
        records=(),
        alpha=options.alpha,
        seed=options.seed,
        threads=options.threads,
        verdict=decided[0],
        reason=decided[1],
        causes=tuple(findings) if poor is None else (),
        bank=tuple(bank),
        gain={},
        hypothesis=hypothesis,
        noise=dict(noise),
        traces=(),
        where=(),
        next_manoeuvre=next_manoeuvre(poor, findings),
        wall_s=0.0,
        cpu_s=0.0,
        doubts=doubts,
    )
