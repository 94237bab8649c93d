"""The track against heading and log where the model holds no track: sensor causes that need no dynamics.

A response model says nothing of sway and positions, yet (north, east)' = R(psi) (surge, sway) must hold among the
records' own channels.  What is left of the positions, less the velocities' integral, is regressed on what each sensor
error would leave there; a steady drift of each record (a current, where speeds are through the water) is estimated
along (`series.whitened`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.base import SensorError
from ...checks.comparison.series import NEEDED, SensorEffect, path_of, whitened
from ...checks.result import NORMAL_90, Size
from ...checks.statistics.tails import log_tail
from ...datasets.instruments import corrected
from ...models.linear_algebra import finite
from ..causes.base import Cause
from ..causes.registry import bank
from ..result import Finding
from ..selection.ties import MOST_TIED, TIE_NATS

if TYPE_CHECKING:
    from ...datasets.record import Record

SHARE = 0.1
"""Share of the family-wise level that this stage spends."""
STEPS, MOST = 4, 2
LEAST_DELAY = 0.1
"""Share of the sampling step below which a delay is not told from how velocities were made."""
SEPARATE = "rudder manoeuvres with a model that holds sway, or the compass and the log checked each by itself"


class Option(NamedTuple):
    """A cause with one of its effects on the track."""

    cause: Cause
    effect: SensorEffect


@dataclass(frozen=True)
class Tracks:
    """What the stage found: findings, instruments that correct the records, and each cause's statistic."""

    findings: tuple[Finding, ...] = ()
    instruments: tuple[tuple[str, float], ...] = ()
    statistics: tuple[tuple[Cause, float], ...] = ()


def usable(records: Sequence[Record]) -> list[Record]:
    """Records that hold heading, both speeds and both positions."""
    return [r for r in records if r.has(*NEEDED) and np.isfinite(r.column("north_m")).sum() > 20]


def rivals(entry: Cause) -> tuple[Cause, ...]:
    """Causes that the track alone cannot tell from one."""
    known = {c.id: c for c in bank()}
    return tuple(known[name] for name in getattr(entry, "track_rivals", ()))


def options(only: Collection[Cause] | None) -> list[Option]:
    """Every effect on the track of the causes (None: of all)."""
    chosen = [c for c in bank() if only is None or c in only]
    return [Option(c, effect) for c in chosen if isinstance(c, SensorError) for effect in c.track]


def compare(records: Sequence[Record], alpha: float, only: Collection[Cause] | None = None) -> Tracks:
    """Sensor causes that the tracks show, at most two, by forward selection at a share of the level `alpha`.

    What is below its floor is neither told nor corrected.
    """
    records, tried = usable(records), options(only)
    if not records or not tried:
        return Tracks()
    threshold = np.log(SHARE * alpha / (len(tried) * MOST))
    chosen: dict[Option, tuple[Cause, ...]] = {}
    first: dict[Option, float] = {}
    passed: list[float] = []
    while True:
        values, spread = _fitted(records, [*chosen])
        if len(chosen) == MOST:
            break
        left = [o for o in tried if o.cause not in [x.cause for x in chosen]]
        statistics = {o: _statistic(records, [*chosen], values, o) for o in left}
        first = first or dict(statistics)
        best = max(statistics, key=lambda o: statistics[o], default=None)
        if best is None or log_tail(statistics[best], 1) > threshold:
            break
        near = [best, *(o for o in statistics if statistics[best] - statistics[o] < 2.0 * TIE_NATS)]
        alike = dict.fromkeys(x for o in near for x in (o.cause, *rivals(o.cause)))
        chosen[best] = tuple(x for x in alike if x != best.cause)
        passed.append(statistics[best])
    paths = [path_of(r) for r in records]
    material = [
        abs(v) > np.median([o.effect.floor(path) for path in paths]) for o, v in zip(chosen, values, strict=True)
    ]
    told = [
        one for one, matters in zip(zip(chosen, values, spread, passed, strict=True), material, strict=True) if matters
    ]
    instruments = {slot: float(v) for o, v, _, _ in told for slot in o.effect.instruments}
    findings = tuple(
        _finding(o, chosen[o][:MOST_TIED], float(v), float(sd), statistic, len(tried)) for o, v, sd, statistic in told
    )
    best_of = {o.cause: max(first[x] for x in first if x.cause == o.cause) for o in first}
    best_of |= {other: best_of[c] for c in list(best_of) for other in rivals(c)}
    return Tracks(findings, tuple(instruments.items()), tuple(best_of.items()))


def _finding(o: Option, ties: tuple[Cause, ...], value: float, sd: float, statistic: float, tests: int) -> Finding:
    effect = o.effect
    size = Size(effect.parameter, value, value - NORMAL_90 * sd, value + NORMAL_90 * sd, effect.unit)
    said = f"heading and log lead off the positions as it would: likelihood-ratio statistic {statistic:.1f}"
    adjusted = float(min(1.0, np.exp(log_tail(statistic, 1)) * tests))
    return Finding(
        o.cause.id,
        tuple(c.id for c in ties),
        "kinematics",
        statistic,
        adjusted,
        (size,),
        evidence=said,
        separate_by=SEPARATE if ties else None,
    )


def _fitted(records: Sequence[Record], chosen: Sequence[Option]) -> tuple[np.ndarray, np.ndarray]:
    """Sizes of the chosen effects and their standard errors: Gauss-Newton steps on corrected records."""
    values, spread = np.zeros(len(chosen)), np.zeros(len(chosen))
    for _ in range(STEPS if chosen else 0):
        y, x = _rows(records, chosen, values, chosen)
        inverse = np.linalg.pinv(finite(x.T @ x))
        step = inverse @ x.T @ y
        error = y - x @ step
        values = values + step[: len(chosen)]
        late = [i for i, o in enumerate(chosen) if o.effect.delay]
        values[late] = np.maximum(values[late], 0.0)
        spread = np.sqrt(np.diag(inverse)[: len(chosen)] * np.mean(error**2) / _independent_share(error))
    return values, spread


def _statistic(records: Sequence[Record], chosen: Sequence[Option], values: np.ndarray, o: Option) -> float:
    """N log(RSS0 / RSS1) of one effect more; 0 for a delay that would be negative or is far below the sampling step."""
    y, x = _rows(records, chosen, values, [*chosen, o])
    column = len(chosen)
    rest = np.delete(x, column, axis=1)
    without = y - rest @ np.linalg.lstsq(finite(rest), y, rcond=None)[0]
    solution = np.linalg.lstsq(finite(x), y, rcond=None)[0]
    with_it = y - x @ solution
    if o.effect.delay and solution[column] < LEAST_DELAY * records[0].dt:
        return 0.0
    gain = np.log(max(without @ without, 1e-300) / max(with_it @ with_it, 1e-300))
    return float(_independent_share(with_it) * y.size * gain)


def _independent_share(error: np.ndarray) -> float:
    """Share of the samples that count as independent where whitened errors (N,) are still correlated."""
    size = float(error @ error)
    rho = float(np.clip(error[1:] @ error[:-1] / size, 0.0, 0.98)) if size > 0.0 else 0.0
    return (1.0 - rho) / (1.0 + rho)


def _rows(
    records: Sequence[Record], chosen: Sequence[Option], values: np.ndarray, effects: Sequence[Option]
) -> tuple[np.ndarray, np.ndarray]:
    """Whitened departures of the tracks (N,) and columns (N, k + drifts) at records corrected for `chosen`."""
    instruments = {slot: float(v) for o, v in zip(chosen, values, strict=True) for slot in o.effect.instruments}
    parts = [whitened(corrected(r, instruments), [o.effect for o in effects]) for r in records]
    drifts = sum(p[2].shape[1] for p in parts)
    y, x, at = [], [], 0
    for departure, columns, drift in parts:
        wide = np.zeros((len(departure), drifts))
        wide[:, at : at + drift.shape[1]] = drift
        at += drift.shape[1]
        y.append(departure)
        x.append(np.hstack([columns, wide]))
    return np.concatenate(y), np.vstack(x)
