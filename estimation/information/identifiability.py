"""Identifiability of a model's parameters from records: their precision, their combinations, and useful manoeuvres.

All of it follows from the Fisher information of the free run at the model's coefficients, for white noise on the
measured states, unknown initial states and inputs that are exactly known (`bounds`): noise of a measured rudder drives
the free run and comes on top.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...datasets.signals import sensor_sd
from ...models.display import html_table
from ...models.errors import CannotFit
from ...models.linear_algebra import svd
from ..likelihood.linear_problem import NULL
from ..likelihood.unknowns import Unknowns
from ..numerics import factors
from ..records.series import MEASURED, samples
from ..results.fit import blas_limited, prepared
from .bounds import information
from .design import candidate_information, information_gain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...datasets.record import Record
    from ...models.model import Model

PRECISE, ROUGH = 0.1, 0.5
"""Relative standard deviations up to which a parameter counts as well determined, and as roughly determined."""
CORRELATED = 0.8
"""Mean correlation between the errors of parameters above which they count as one group."""
TERMS = 4
"""Terms up to which a combination is written in the text."""


class ParameterPrecision(NamedTuple):
    """A published parameter: its value, its smallest standard deviation (inf: not determined), and their ratio."""

    name: str
    unit: str
    value: float
    sd: float
    relative: float
    """nan for a value of zero."""


class ParameterGroup(NamedTuple):
    """Parameters with strongly correlated errors, and the combination of them that is determined best."""

    names: tuple[str, ...]
    combination: tuple[tuple[str, float], ...]
    """Name and factor; the combination is the sum of factor times parameter."""
    relative: float
    """Its relative standard deviation."""

    @property
    def known(self) -> str:
        """The combination and its relative standard deviation: `T2 - 0.3 T3, to 5.1 %`."""
        terms = " ".join(f"{'-' if f < 0.0 else '+'} {_times(f)}{name}" for name, f in self.combination)
        return f"{terms.removeprefix('+ ')}, to {_percent(self.relative)}"


class CandidateManoeuvre(NamedTuple):
    """A further manoeuvre, the median and worst relative bound with a record of it added, and its information in nats.

    The information counts on all parameters together, each taken as known within 100 % before (`design`).
    """

    manoeuvre: str
    median: float
    worst: float
    information: float


@dataclass(frozen=True, repr=False)
class Identifiability:
    """The report; `noise_sd` by channel, candidates sorted by their information, the largest first."""

    model: str
    noise_sd: dict[str, float]
    parameters: tuple[ParameterPrecision, ...]
    groups: tuple[ParameterGroup, ...]
    candidates: tuple[CandidateManoeuvre, ...]

    @property
    def relative(self) -> np.ndarray:
        """Relative bounds of the parameters that are not zero."""
        return np.array([p.relative for p in self.parameters if not np.isnan(p.relative)])

    @property
    def names(self) -> tuple[list[str], list[str], list[str]]:
        """Parameters determined within 10 %, within 10-50 %, and not determined; those of zero value are left out."""
        edges = ((-np.inf, PRECISE), (PRECISE, ROUGH), (ROUGH, np.inf))
        nonzero = [p for p in self.parameters if not np.isnan(p.relative)]
        precise, rough, poor = ([p.name for p in nonzero if low <= p.relative < high] for low, high in edges)
        return precise, rough, poor + [p.name for p in nonzero if np.isinf(p.relative)]

    @property
    def combinations(self) -> list[ParameterGroup]:
        """Groups of a few parameters of which a combination is determined within 10 %, and none of them alone."""
        weak = {n for names in self.names[1:] for n in names}
        return [g for g in self.groups if g.relative < PRECISE and len(g.names) <= TERMS and weak >= {*g.names}]

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of these parameters."""
        precise, rough, poor = self.names
        return len(precise), len(rough), len(poor)

    @property
    def median(self) -> float:
        """Median relative bound."""
        return float(np.median(self.relative))

    @property
    def worst(self) -> float:
        """Largest relative bound."""
        return float(np.max(self.relative))

    @property
    def advice(self) -> tuple[CandidateManoeuvre, CandidateManoeuvre] | None:
        """The candidates with most information and with the smallest worst bound."""
        if not self.candidates:
            return None
        return self.candidates[0], min(self.candidates, key=lambda c: c.worst)

    def lines(self) -> list[str]:
        """The report in plain language."""
        noise = ", ".join(f"{channel} {sd:.2g}" for channel, sd in self.noise_sd.items())
        found = [f"identifiability (Cramer-Rao bounds for sensor noise {noise}; inputs taken as exact)"]
        titles = ("determined within 10 %", "determined within 10-50 %", "not determined")
        for title, names in zip(titles, self.names, strict=True):
            found.append(f"  {title} ({len(names)}): {', '.join(names) or 'none'}")
        found += [f"  {line}" for line in self.group_lines()]
        return found + [f"  {line}" for line in self._advice()]

    def group_lines(self) -> list[str]:
        """Of each group, the combination that the records tell."""
        return [_sentence(group) for group in self.groups]

    def _advice(self) -> list[str]:
        if self.advice is None:
            return []
        best, by_worst = self.advice
        median = f"median bound {_percent(self.median)} -> {_percent(best.median)}"
        worst = f"worst {_percent(self.worst)} -> {_percent(best.worst)}"
        lines = [f"most useful next manoeuvre: {best.manoeuvre} ({best.information:.2g} nats, {median}, {worst})"]
        if by_worst.manoeuvre != best.manoeuvre:
            lines.append(f"for the worst parameter: {by_worst.manoeuvre} (worst bound -> {_percent(by_worst.worst)})")
        return lines

    def plot(self) -> Figure:
        """Draw the smallest relative standard deviation of every parameter; a matplotlib figure, not of pyplot.

        The axis is logarithmic; parameters that are not determined have no point.
        """
        from ...models.figure import ShownFigure

        names = [one.name for one in self.parameters]
        values = [one.relative if np.isfinite(one.relative) else np.nan for one in self.parameters]
        figure = ShownFigure(7.5, 1.2 + 0.22 * len(names))
        axes = figure.subplots()
        axes.plot(values, range(len(names)), "o", color="#1b6ca8", markersize=4)
        for edge in (PRECISE, ROUGH):
            axes.axvline(edge, color="#5b6b7b", linewidth=0.8, linestyle="--")
        axes.set_yticks(range(len(names)), names)
        axes.set(xscale="log", ylim=(len(names) - 0.5, -0.5), xlabel="smallest relative standard deviation")
        axes.grid(True, linewidth=0.3)
        return figure

    def __repr__(self) -> str:
        counts = ", ".join(
            f"{n} {name}" for n, name in zip(self.counts, ("within 10 %", "within 50 %", "not determined"), strict=True)
        )
        return f"<Identifiability of {self.model}: {counts}>"

    def _repr_html_(self) -> str:
        rows = [(one.name, f"{one.value:.5g}", one.unit, _share(one.relative)) for one in self.parameters]
        table = html_table(("parameter", "value", "unit", "smallest relative standard deviation"), rows)
        return f"{table}<pre>{escape(chr(10).join(self.lines()))}</pre>"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "model": self.model,
            "noise_sd": self.noise_sd,
            "parameters": [parameter._asdict() for parameter in self.parameters],
            "counts": dict(zip(("within_10_percent", "within_50_percent", "not_determined"), self.counts, strict=True)),
            "groups": [
                {"names": list(g.names), "combination": dict(g.combination), "relative": g.relative}
                for g in self.groups
            ],
            "median": self.median,
            "worst": self.worst,
            "candidates": [candidate._asdict() for candidate in self.candidates],
        }


def identifiability(
    model: Model,
    records: Sequence[Record],
    noise_sd: Mapping[str, float] | None = None,
    manoeuvres: Sequence[str] | None = None,
) -> Identifiability:
    """Identifiability of a model's published parameters from records.

    Parameters
    ----------
    model : with the coefficients at which to compute the bounds.
    records : inputs, sampling, gaps and initial states are taken from them.
    noise_sd : standard deviation by channel name; None estimates it from the records.
    manoeuvres : texts of further manoeuvres to compare, simulated with the model for as long as the longest record;
        None takes some zigzags, turns, sines and random steps of the records' size, an empty list none.

    Raises
    ------
    CannotFit : the records do not suit the model, it has no coefficients, or all parameters are zero.
    BadInput : a manoeuvre or a channel of the noise is not known.
    """
    records = prepared(records, model)
    noise = dict(noise_sd) if noise_sd is not None else noise_of(records)
    scale, values, names, units = _published(model)
    with blas_limited(), np.errstate(all="ignore"):
        factor = np.vstack([information(model, record, noise) for record in records]) @ scale
        sd = _sd(factor)
        relative = _relative(sd, values)
        if np.isnan(relative).all():
            raise CannotFit(f"every parameter of {model.id} is zero: there are no relative errors")
        columns = (names, units, values.tolist(), sd.tolist(), relative.tolist())
        parameters = tuple(map(ParameterPrecision, *columns))
        groups = _groups(factor, values, relative, names)
        candidates = []
        for text, more in candidate_information(model, records, noise, manoeuvres):
            bounds = _relative(_sd(np.vstack([factor, more @ scale])), values)
            gain = _gain(factor * np.abs(values), more @ scale * np.abs(values))
            candidates.append(CandidateManoeuvre(text, float(np.nanmedian(bounds)), float(np.nanmax(bounds)), gain))
    order = sorted(candidates, key=lambda c: -c.information)
    return Identifiability(model.id, noise, parameters, groups, tuple(order))


def _gain(now: np.ndarray, more: np.ndarray) -> float:
    """Information of factors (rows, q) on relative parameters, to which a prior of 100 % each is added, nats."""
    return information_gain(now.T @ now + np.eye(now.shape[1]), more.T @ more)


def _relative(sd: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Standard deviations relative to the values; nan for a value of zero."""
    return sd / np.abs(np.where(values != 0.0, values, np.nan))


def noise_of(records: Sequence[Record]) -> dict[str, float]:
    """Standard deviation of the noise by channel, estimated from the records; `low` noise where none is visible."""
    from ...datasets.sensors import NOISE
    from ...models.model import CHANNELS

    found = {}
    for symbol in MEASURED:
        columns = [v for record in records if (v := samples(record, symbol)) is not None and np.isfinite(v).any()]
        if not columns:
            continue
        sd = float(np.sqrt(np.mean([sensor_sd(v) ** 2 for v in columns])))
        size = max(np.nanmax(np.abs(v)) for v in columns)
        name = CHANNELS[symbol]
        plain = name.removesuffix("_rad_s").removesuffix("_m_s").removesuffix("_rad")
        found[name] = sd if sd > 1e-6 * size else NOISE["low"][plain]
    return found


def _published(model: Model) -> tuple[np.ndarray, np.ndarray, tuple[str, ...], tuple[str, ...]]:
    """d coefficients / d parameters, and the parameters' values, names and units.

    Coefficients without real published parameters count as parameters themselves.
    """
    values = model.to_parameters(model.coefficients)
    if np.isfinite(values).all():
        return Unknowns.all_of(model).jacobian(values), values, model.parameter_names, model.parameter_units
    p = len(model.coordinates)
    return np.eye(p), model.coefficients, model.coordinates, ("",) * p


def _sd(factor: np.ndarray) -> np.ndarray:
    """Standard deviations (q,) from a factor (rows, q) of the information; inf where a parameter is not determined."""
    empty = np.zeros((len(factor), 1))
    return np.sqrt(np.diag(factors.solve(np.hstack([factor, empty]), NULL).covariance))


def _groups(
    factor: np.ndarray, values: np.ndarray, relative: np.ndarray, names: tuple[str, ...]
) -> tuple[ParameterGroup, ...]:
    """Groups of parameters that are not well determined, by the correlation of their errors."""
    from scipy.cluster.hierarchy import fcluster, linkage

    length = np.linalg.norm(factor, axis=0)
    weak = np.flatnonzero(~(relative < PRECISE) & (length > 0.0))
    if weak.size < 2:
        return ()
    covariance = _regular(factor / np.where(length > 0.0, length, 1.0))
    sd = np.sqrt(np.diag(covariance))[weak]
    distance = 1.0 - np.abs(covariance[np.ix_(weak, weak)]) / np.outer(sd, sd)
    pairs = np.maximum(distance[np.triu_indices(weak.size, 1)], 0.0)
    labels = fcluster(linkage(pairs, "average"), 1.0 - CORRELATED, "distance")
    found = [weak[labels == label] for label in range(1, labels.max() + 1)]
    groups = [g for g in found if g.size > 1 and np.any(values[g])]
    return tuple(_group(g, covariance, length, values, names) for g in sorted(groups, key=lambda g: int(g[0])))


def _regular(unit: np.ndarray) -> np.ndarray:
    """Covariance (q, q) in units of the columns' lengths; undetermined directions get a large finite variance."""
    _, s, vt = svd(unit, full_matrices=False)
    s = np.maximum(s, NULL * s[0])
    return (vt.T / s**2) @ vt


def _group(
    members: np.ndarray, covariance: np.ndarray, length: np.ndarray, values: np.ndarray, names: tuple[str, ...]
) -> ParameterGroup:
    """A group and its best determined combination w'theta: w = C^-1 theta has the largest (w'theta)^2/(w'C w)."""
    block = covariance[np.ix_(members, members)]
    sd, effects = np.sqrt(np.diag(block)), values[members] * length[members]
    variance, axes = np.linalg.eigh(block / np.outer(sd, sd))
    inverse = (axes / np.maximum(variance, NULL)) @ axes.T
    weights = inverse @ (effects / sd) / sd
    factor = weights * length[members]
    factor /= factor[int(np.argmax(np.abs(weights)))]
    own = tuple(names[i] for i in members.tolist())
    relative = 1.0 / np.sqrt((effects / sd) @ inverse @ (effects / sd))
    return ParameterGroup(own, tuple(zip(own, factor.tolist(), strict=True)), float(relative))


def _share(relative: float) -> str:
    return "not determined" if np.isinf(relative) else "" if np.isnan(relative) else f"{100.0 * relative:.2g} %"


def _sentence(group: ParameterGroup) -> str:
    names = f"{{{', '.join(group.names)}}}"
    if not group.relative < ROUGH:
        return f"{names} not determined, not even a combination of them"
    if len(group.names) > TERMS:
        return f"{names} only one combination of them, to {_percent(group.relative)}"
    return f"{names} only {group.known}"


def _times(factor: float) -> str:
    text = f"{abs(factor):.3g}"
    return "" if text == "1" else f"{text} "


def _percent(share: float) -> str:
    return "any size" if not share < 1e4 else f"{100.0 * share:.2g} %" if share < 1.0 else f"{100.0 * share:.0f} %"
