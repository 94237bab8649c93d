"""The certificate of a model on one page: what it was tried on, its errors by the time ahead, its limits."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from ..media import html
from ..numbers import DEG, number
from ..page import FAIR, Page, Verdict, items, section
from ..tables import Column, Table, make_table
from .page import free_table, horizon_table, index_table, left_out_table, trusted_lines

if TYPE_CHECKING:
    from ...estimation.validation.result import Measured, Validation
    from ...models.model import Model


REACHES: Mapping[str, tuple[str, str, float]] = {
    "rudder": ("rudder angle", "deg", DEG),
    "yaw_rate": ("yaw rate", "deg/s", DEG),
    "drift": ("drift angle", "deg", DEG),
    "surge": ("surge speed", "m/s", 1.0),
}
"""What a record holds -> what it is called, its unit, and the factor to it."""

LIMITS = (
    "Nothing is said of a motion outside these ranges, of another loading, depth, wind or sea than that of the "
    "records, or of channels that are not in the tables. Records that took part in the fit of the model are no test of "
    "it."
)


def certificate(validation: Validation) -> str:
    """The page of the first model, self-contained, for one sheet of paper."""
    name, model = next(iter(validation.models.items()))
    own = replace(
        validation,
        models={name: model},
        scores=tuple(score for score in validation.scores if score.model == name),
        indices=tuple(index for index in validation.indices if index.model == name),
        trusted_s={key: time for key, time in validation.trusted_s.items() if key == name},
    )
    first, *told = trusted_lines(own) or ["no time ahead was tried: the records are too short"]
    parts = (
        section("Tried on", [record_table(own)]),
        section("Errors of free runs", [free_table(own), left_out_table(own)]),
        section("Errors by the time ahead", [horizon_table(own)]),
        section("Manoeuvring indices", [index_table(own)]),
        section("Limits", [LIMITS, items(limits(own))]),
    )
    verdict = Verdict(FAIR, f"{first}.", tuple(f"{line}." for line in told))
    shown = Page(
        f"Adequacy of the model {name}", _about(model), verdict, own.doubts, tuple(one for one in parts if one.blocks)
    )
    return html(shown, sheet=True)


def _about(model: Model) -> str:
    facts = (
        model.title,
        f"family {model.family}, positive rudder to {model.positive_rudder}",
        model.source,
        f"numbers {digest(model)}",
        f"helmbench {version('helmbench')}",
        "nothing was fitted",
    )
    return "; ".join(filter(None, facts))


def digest(model: Model) -> str:
    """SHA-256 of family, sign, coefficients and constants: the same for the same equations and numbers."""
    facts = [model.family, model.positive_rudder, model.coefficients.tolist(), model.constants.tolist()]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:16]


def reach_of(record: Measured) -> dict[str, tuple[float, float]]:
    """Least and largest value in a record by key of `REACHES`: angles and rates in rad, m/s; nan: not measured."""
    none = np.full(record.time_s.size, np.nan)
    surge, sway = (record.channels.get(channel, none) for channel in ("surge_m_s", "sway_m_s"))
    drift = np.where(np.hypot(surge, sway) > 0.0, np.arctan2(-sway, surge), np.nan)
    yaw_rate = record.channels.get("yaw_rate_rad_s", none)
    found = {"rudder": record.rudder, "yaw_rate": yaw_rate, "drift": drift, "surge": surge}
    return {name: _ends(values) for name, values in found.items()}


def _ends(values: np.ndarray) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)


def limits(validation: Validation) -> list[str]:
    """Sentences: beyond what the certificate says nothing."""
    each, lines = [reach_of(record) for record in validation.records], []
    for name, (title, unit, factor) in REACHES.items():
        low, high = (factor * end for end in _ends(np.array([one[name] for one in each]).ravel()))
        known = np.isfinite(low)
        lines.append(f"{title} {number(low)} to {number(high)} {unit}" if known else f"{title}: not measured")
    diverged = [f"{run.record}: {run.told}" for run in validation.runs if run.told and run.model in validation.models]
    return [*lines, *diverged]


def record_table(validation: Validation) -> Table:
    """A row a record: duration, samples and ranges."""
    columns = [
        Column("record", lambda record: record.name),
        Column("duration, s", lambda record: number(record.time_s[-1] - record.time_s[0])),
        Column("samples", lambda record: str(record.time_s.size)),
    ]
    for field, (title, unit, factor) in REACHES.items():
        columns.append(Column(f"{title}, {unit}", lambda r, f=field, k=factor: _range(reach_of(r)[f], k)))
    return make_table(columns, validation.records)


def _range(ends: tuple[float, float], factor: float) -> str:
    return " to ".join(number(factor * end) for end in ends)
