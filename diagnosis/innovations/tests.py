"""Tests of the innovations that need no description of an effect: they must agree with gusts.

Innovations of a force that acts only in parts of the manoeuvre are too large there and too small elsewhere; what a
cause only resembles asks for another size of it elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.tails import chi2_quantile, log_tail, normal_log_tail
from ...estimation.filters.innovations.vector import SYMBOLS
from ...models.model import CHANNELS as COLUMNS
from .features import word

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations
    from ..causes.base import Cause
    from .score_tests import Projector


ENOUGH = 50
"""Products of innovations, above which a correlation is taken from them."""
KEPT, FADED, LATER = 0.3, 0.5, 20
"""Correlation from sample to sample above which noise has a memory, and the share of it that is left LATER samples on
below which it is noise."""


def activity_tests(est: Estimator, now: Innovations) -> list[tuple[str, float]]:
    """Log p-values of the squared innovations not depending on what the ship does: (condition, log p).

    The sample that says most for it does not count: one outlier, where little else is like it, is no dependence.
    """
    names = list(est.kernels.STATES)
    r = np.abs(now.states[:, names.index("r")])
    rudder = est.joined(lambda d: np.abs(d.rudder))
    rate = est.joined(lambda d: np.abs(np.gradient(d.rudder, d.time)))
    part = est.joined(lambda d: d.time / d.time[-1])
    conditions = {
        "the yaw rate": r,
        "the rudder angle": rudder,
        "the rudder rate": np.minimum(rate, np.quantile(rate, 0.95)),
        "time": part,
    }
    if est.n_records > 1:
        own = ((name, est.owner == i) for i, name in enumerate(est.record_names))
        conditions |= {f"the record ({name} against others)": inside.astype(float) for name, inside in own}
    out = []
    for label, g in conditions.items():
        for c in np.flatnonzero(est.channels).tolist():
            e = now.e[:, c]
            used = e != 0.0
            if used.sum() < 50 or np.std(g[used]) == 0.0:
                continue
            z = np.minimum(e[used] ** 2, 20.0) - 1.0
            h = (g[used] - g[used].mean()) / np.std(g[used])
            products = (z - z.mean()) * h
            total = float(products.sum())
            most = float((np.sign(total) * products).max())
            t = max(abs(total) - most, 0.0) / np.sqrt(used.sum() * max(np.var(z), 1e-12))
            log_p = float(np.log(2.0) + normal_log_tail(t))
            out.append((f"errors of the {word(c)} that depend on {label}", log_p))
    return out


def size_tests(
    est: Estimator, now: Innovations, projector: Projector, columns: Mapping[Cause, np.ndarray]
) -> list[tuple[str, float]]:
    """Log p-values of each named cause having one size: in every record, early and late, to both sides, hard and soft.

    columns : for each cause the derivatives (k, N*6)
    of the innovations by its parameters; projector : with all of them projected out.
    """
    out = []
    for label, weight in _conditions(est, now).items():
        for cause, own in columns.items():
            parted = (own.reshape(len(own), -1, 6) * weight[:, None]).reshape(len(own), -1)
            out.append((f"another size of {cause.id} {label}", log_tail(projector.score(parted).statistic, len(own))))
    return out


def _conditions(est: Estimator, now: Innovations) -> dict[str, np.ndarray]:
    """Weights (N,) of all samples between -1 and 1, with or against a condition."""
    r = now.states[:, list(est.kernels.STATES).index("r")]
    rudder = est.joined(lambda d: np.abs(d.rudder))
    late = est.joined(lambda d: d.time > 0.5 * d.time[-1])
    conditions = {
        "in the second half of a record": late,
        "in turns to the other side": r > 0.0,
        "at large yaw rates": np.abs(r) > np.median(np.abs(r)),
        "at large rudder angles": rudder > np.median(rudder),
    }
    if est.n_records > 1:
        conditions |= {f"in {name}": est.owner == i for i, name in enumerate(est.record_names)}
    return {label: np.where(chosen, 1.0, -1.0) for label, chosen in conditions.items()}


def rate_statistic(est: Estimator, now: Innovations) -> float:
    """Standard score of squared innovations growing with the squares of their channels' rates of change."""
    total, variance = 0.0, 0.0
    for c in np.flatnonzero(est.channels):
        rates = []
        for i, d in enumerate(est.segments):
            rows = est.samples_of(i)
            rates.append(np.gradient(now.states[rows, est.places[c]], d.time))
        g = np.concatenate(rates) ** 2 * np.exp(-2.0 * now.log_s[:, c])
        used = now.e[:, c] != 0.0
        h = g[used] - g[used].mean()
        total += float(np.sum((np.minimum(now.e[used, c] ** 2, 20.0) - 1.0) * h))
        variance += 2.0 * float(np.sum(h**2))
    return total / np.sqrt(max(variance, 1e-300))


def whiteness_tests(est: Estimator, now: Innovations, lags: int = 12) -> list[tuple[str, float]]:
    """Log p-values of each channel's innovations being white over the first lags (Ljung-Box)."""
    out = []
    for c in np.flatnonzero(est.channels).tolist():
        total, count = _lagged(est, now, c, range(1, lags + 1))
        if count.min() > ENOUGH:
            statistic = float(np.sum(total**2 / count))
            out.append((f"errors of the {word(c)} that depend on those before", log_tail(statistic, lags)))
    return out


class Memory(NamedTuple):
    """A channel whose innovations keep a part of themselves for some samples, as filtered sensors' noise does.

    near, later : correlation from sample to sample, and LATER samples on.  independent : share of its samples that say
    something new about what is constant in the noise, (1 + 2 sum of correlations)^-1.
    """

    channel: str
    near: float
    later: float
    independent: float


def noise_with_memory(est: Estimator, now: Innovations) -> list[Memory]:
    """Channels whose innovations are correlated from sample to sample, and much less LATER samples on.

    An effect that the model lacks lasts longer: its correlations fall little over LATER samples.
    """
    out = []
    for c in np.flatnonzero(est.channels).tolist():
        total, count = _lagged(est, now, c, range(LATER + 1))
        if count.min() > ENOUGH:
            size, *kept = (total / count).tolist()
            correlation = np.maximum(np.array(kept) / size, 0.0)
            near, later = float(correlation[0]), float(correlation[-1])
            if near > KEPT and later < FADED * near:
                out.append(Memory(COLUMNS[SYMBOLS[c]], near, later, 1.0 / (1.0 + 2.0 * float(correlation.sum()))))
    return out


def _lagged(est: Estimator, now: Innovations, c: int, lags: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Sums (L,) of the products of a channel's innovations so many samples apart, and (L,) numbers of products."""
    total, count = np.zeros(len(lags)), np.zeros(len(lags))
    for i in range(len(est.segments)):
        e = np.clip(now.e[est.edges[i] + 10 : est.edges[i + 1], c], -4.5, 4.5)
        for j, k in enumerate(lags):
            products = e[k:] * e[: -k or None]
            total[j] += products.sum()
            count[j] += np.count_nonzero(products)
    return total, count


def line_test(est: Estimator, now: Innovations) -> tuple[float, float]:
    """A spectral line in the innovations of heading, yaw rate and sway: log p and its angular frequency (rad/s)."""
    best = (0.0, 1.0)
    dt = est.segments[0].step_s
    size = 4096
    omega = 2.0 * np.pi * np.fft.rfftfreq(size, dt)
    shortest = min(d.time[-1] for d in est.segments)
    band = np.flatnonzero((omega > 2.0 * np.pi * 3.0 / shortest) & (omega < 0.3 * np.pi / dt))
    for c in np.flatnonzero(est.channels[:4]) if band.size else ():
        power, runs = np.zeros(omega.size), 0
        for i in range(len(est.segments)):
            e = np.clip(now.e[est.edges[i] + 6 : est.edges[i + 1], c], -4.5, 4.5)
            if np.count_nonzero(e) < 50:
                continue
            taper = np.hanning(e.size)
            power += np.abs(np.fft.rfft(e * taper, n=size)) ** 2 / np.sum(taper**2)
            runs += 1
        if not runs:
            continue
        median = chi2_quantile(0.5, 2 * runs) / 2.0
        background = [np.median(power[max(3, k - 80) : k + 80]) / median for k in band.tolist()]
        level = 2.0 * power[band] / np.maximum(background, 0.9)
        k = int(np.argmax(level))
        tests = 3.0 * shortest / dt / 4.0
        best = min(best, (log_tail(float(level[k]), 2 * runs) + np.log(tests), float(omega[band[k]])))
    return best
