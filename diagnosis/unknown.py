"""What no named cause explains: a dictionary of generic forces and sensor shifts, and tests of gusts being gusts.

Each feature is a time series made from the filter's own states and the record's inputs, added to one force or one
channel.  Zero-mean gusts with one correlation time depend on none of them, so a feature that the innovations ask for
is missing physics.  What no feature catches still betrays itself: innovations of a force that acts only in parts of
the manoeuvre are too large there and too small elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..methods.innovations.estimator import SYMBOLS, Estimator, Innovations, Parameter, Setting

if TYPE_CHECKING:
    from .evidence import Projector

LAGS_S = (5.0, 12.0, 30.0, 75.0)
LINES = (0.08, 0.6)
"""Angular frequencies of periodic moments that are tried, rad/s for a 160 m ship."""
WINDOWS = 24
"""Windows a record is cut into for effects that act for a while."""


@dataclass(frozen=True)
class Feature:
    """A unit-size series (one array (T,) a record) added to axis `axis` (a force, or channel axis - nf)."""

    name: str
    axis: int
    series: tuple[np.ndarray, ...]
    family: str

    def parameter(self, est: Estimator) -> Parameter:
        """The feature's size as a parameter of the filter."""
        return Parameter(f"{self.name}:{self.axis}", "", series=(self.axis, self.series), scale=1e-6)


def features(est: Estimator, s: Setting, now: Innovations, clock: float) -> list[Feature]:
    """The dictionary at a setting: every basis series on every force, and slow shifts of every channel."""
    basis: dict[str, tuple[str, list[np.ndarray]]] = {}
    for i, d in enumerate(est.data):
        states = now.states[est.edges[i] : est.edges[i + 1]]
        for name, (family, values) in _basis(est, states, d.time, d.rudder, clock).items():
            basis.setdefault(name, (family, []))[1].append(values)
    nf, found = est.n_forces, []
    for name, (family, arrays) in basis.items():
        series = _standard(arrays)
        if series is None:
            continue
        found += [Feature(name, axis, series, family) for axis in range(nf)]
    ramp = _standard([d.time / d.time[-1] - 0.5 for d in est.data])
    for c in np.flatnonzero(est.channels):
        if ramp is not None:
            found.append(Feature(f"drift of {SYMBOLS[c]}", nf + int(c), ramp, "sensor"))
        for kind, arrays in _channel_shapes(est, now, int(c)).items():
            series = _standard(arrays)
            if series is not None:
                found.append(Feature(f"{kind} of {SYMBOLS[c]}", nf + int(c), series, "sensor"))
    return found


def _standard(arrays: Sequence[np.ndarray]) -> tuple[np.ndarray, ...] | None:
    size = np.sqrt(np.mean(np.concatenate(arrays) ** 2))
    if not np.isfinite(size) or size < 1e-12:
        return None
    return tuple(np.ascontiguousarray(a / size) for a in arrays)


def _basis(est: Estimator, states: np.ndarray, time: np.ndarray, rudder: np.ndarray, clock: float):
    """Series of one record by name: family and values (T,)."""
    names = list(est.kernels.STATES)
    r, psi = states[:, names.index("r")], states[:, names.index("psi")]
    smooth = np.clip(rudder, -10.0, 10.0)
    signals = {"r": r / max(np.std(r), 1e-9), "d": smooth / max(np.std(smooth), 1e-9)}
    if est.model.is_3dof:
        v, u = states[:, names.index("v")], states[:, names.index("u")]
        signals["v"] = v / max(np.std(v), 1e-9)
        loss = u / est.model.speed_m_s - 1.0
        signals["u"] = loss / max(np.std(loss), 1e-9)
    out: dict[str, tuple[str, np.ndarray]] = {}
    keys = list(signals)
    for i, a in enumerate(keys):
        x = signals[a]
        out[a] = ("linear", x)
        out[f"|{a}|"] = ("even", np.abs(x))
        out[f"{a}^2"] = ("even", x**2)
        out[f"{a}|{a}|"] = ("odd", x * np.abs(x))
        out[f"{a}^3"] = ("odd", x**3)
        out[f"stall {a}"] = ("odd", np.sign(x) * np.maximum(np.abs(x) - np.quantile(np.abs(x), 0.75), 0.0))
        out[f"dead {a}"] = ("odd", np.clip(x, -0.3, 0.3))
        out[f"port {a}"] = ("even", np.maximum(x, 0.0))
        for b in keys[i + 1 :]:
            y = signals[b]
            out[f"{a}{b}"] = ("product", x * y)
            out[f"{a}|{b}|"] = ("product", x * np.abs(y))
            out[f"{b}|{a}|"] = ("product", y * np.abs(x))
            out[f"{a}^2{b}"] = ("product", x**2 * y)
            out[f"{a}{b}^2"] = ("product", x * y**2)
    for a, x in signals.items():
        for lag in LAGS_S:
            late = lagged(x, time, lag * clock)
            out[f"{a} late {lag:g}"] = ("memory", late)
        out[f"sign {a} late"] = ("memory", np.sign(lagged(x, time, 12.0 * clock)))
        rate = np.gradient(lagged(x, time, 2.0 * clock), time)
        rate /= max(np.std(rate), 1e-12)
        out[f"rate {a}"] = ("rate", rate)
        out[f"|rate {a}|"] = ("rate", np.abs(rate))
    part = time / time[-1] - 0.5
    out["time"] = ("drift", part)
    out["time^2"] = ("drift", part**2 - 1.0 / 12.0)
    for a, x in signals.items():
        out[f"time {a}"] = ("drift", part * x)
    for m in (1, 2, 3):
        out[f"cos {m} psi"] = ("heading", np.cos(m * psi))
        out[f"sin {m} psi"] = ("heading", np.sin(m * psi))
    for wave, label in ((np.cos(psi), "cos"), (np.sin(psi), "sin")):
        for a in ("r", "d"):
            out[f"{a} {label} psi"] = ("heading", signals[a] * wave)
    if est.model.is_3dof:
        for name in ("x", "y"):
            place = states[:, names.index(name)]
            reach = place - place.mean()
            span = max(np.std(reach), 1e-9)
            out[name] = ("place", reach / span)
            out[f"{name}^2"] = ("place", (reach / span) ** 2)
            for a in ("r", "d"):
                out[f"{a} {name}"] = ("place", signals[a] * reach / span)
    return out


def lagged(x: np.ndarray, time: np.ndarray, lag: float) -> np.ndarray:
    """First-order lag of a series (T,)."""
    from scipy.signal import lfilter

    dt = float(np.median(np.diff(time)))
    share = 1.0 - np.exp(-dt / lag)
    return lfilter([share], [1.0, share - 1.0], x, zi=[(1.0 - share) * x[0]])[0]


def _channel_shapes(est: Estimator, now: Innovations, c: int) -> dict[str, list[np.ndarray]]:
    """Ways in which one channel alone can depart: growing with its value, its size, other motions, or time."""
    names = list(est.kernels.STATES)
    r = now.states[:, names.index("r")]
    x = now.states[:, est.layout[6 + c]]
    shapes = {"curve": [], "even": [], "lever": [], "jump": [], "drift^2": []}
    for i, d in enumerate(est.data):
        rows = slice(est.edges[i], est.edges[i + 1])
        own = x[rows] - x[rows].mean()
        shapes["curve"].append(own**3)
        shapes["even"].append(np.abs(own))
        shapes["lever"].append(r[rows])
        shapes["jump"].append(np.sign(d.time - 0.5 * d.time[-1]))
        part = d.time / d.time[-1] - 0.5
        shapes["drift^2"].append(part**2 - 1.0 / 12.0)
    if SYMBOLS[c] == "r":
        del shapes["lever"]
    return shapes


def pulses(est: Estimator) -> list[list[tuple[np.ndarray, ...]]]:
    """Unit series over each window of each record, and last of all records at the same time: [record][window]."""
    found = []
    for i, d in enumerate(est.data):
        edges = np.linspace(0.0, d.time[-1] + 1e-9, WINDOWS + 1)
        still = [np.zeros(other.time.size) for other in est.data]
        inside = [(d.time >= start) & (d.time < end) for start, end in pairwise(edges)]
        found.append([(*still[:i], own.astype(float), *still[i + 1 :]) for own in inside])
    edges = np.linspace(0.0, max(d.time[-1] for d in est.data) + 1e-9, WINDOWS + 1)
    found.append(
        [tuple(((d.time >= start) & (d.time < end)).astype(float) for d in est.data) for start, end in pairwise(edges)]
    )
    return found


def lines(est: Estimator) -> list[tuple[Feature, Feature]]:
    """Yaw moments at a fixed frequency, cosine and sine over the record's time, at frequencies half a bin apart."""
    longest = max(d.time[-1] for d in est.data)
    axis = est.n_forces - 1 if est.model.is_3dof else 0
    found = []
    for omega in np.arange(LINES[0] / est.clock, LINES[1] / est.clock, np.pi / longest):
        waves = [tuple(wave(omega * d.time) for d in est.data) for wave in (np.cos, np.sin)]
        pair = zip(("cos", "sin"), waves, strict=True)
        cosine, sine = (Feature(f"{name} {omega:.3g} t", axis, arrays, "line") for name, arrays in pair)
        found.append((cosine, sine))
    return found


def activity_tests(est: Estimator, now: Innovations) -> list[tuple[str, float]]:
    """Log p-values of the squared innovations not depending on what the ship does: (condition, log p)."""
    from scipy.stats import norm

    names = list(est.kernels.STATES)
    r = np.abs(now.states[:, names.index("r")])
    rudder = np.concatenate([np.abs(d.rudder) for d in est.data])
    rate = np.concatenate([np.abs(np.gradient(d.rudder, d.time)) for d in est.data])
    owner = np.concatenate([np.full(d.time.size, i) for i, d in enumerate(est.data)])
    part = np.concatenate([d.time / d.time[-1] for d in est.data])
    conditions = {
        "yaw rate": r,
        "rudder angle": rudder,
        "rudder rate": np.minimum(rate, np.quantile(rate, 0.95)),
        "time": part,
    }
    conditions |= (
        {f"record {d.name}": (owner == i).astype(float) for i, d in enumerate(est.data)} if len(est.data) > 1 else {}
    )
    out = []
    for label, g in conditions.items():
        for c in np.flatnonzero(est.channels):
            e = now.e[:, c]
            used = e != 0.0
            if used.sum() < 50 or np.std(g[used]) == 0.0:
                continue
            z = np.minimum(e[used] ** 2, 20.0) - 1.0
            h = (g[used] - g[used].mean()) / np.std(g[used])
            t = np.sum((z - z.mean()) * h) / np.sqrt(used.sum() * max(np.var(z), 1e-12))
            out.append((f"{SYMBOLS[c]} with {label}", float(np.log(2.0) + norm.logsf(abs(t)))))
    return out


def size_tests(
    est: Estimator, now: Innovations, projector: Projector, columns: Mapping[str, np.ndarray]
) -> list[tuple[str, float]]:
    """Log p-values of each named cause having one size: in every record, early and late, to both sides, hard and soft.

    What a cause only mimics asks for another size of it elsewhere.  columns : for each cause the derivatives (k, N*6)
    of the innovations by its parameters; projector : with all of them projected out.
    """
    from .evidence import log_tail

    out = []
    for label, weight in _conditions(est, now).items():
        for cause, own in columns.items():
            parted = (own.reshape(len(own), -1, 6) * weight[:, None]).reshape(len(own), -1)
            out.append((f"{cause} of another size with {label}", log_tail(projector.score(parted).statistic, len(own))))
    return out


def _conditions(est: Estimator, now: Innovations) -> dict[str, np.ndarray]:
    """Weights (N,) of all samples between -1 and 1, with or against a condition."""
    r = now.states[:, list(est.kernels.STATES).index("r")]
    rudder = np.concatenate([np.abs(d.rudder) for d in est.data])
    late = np.concatenate([d.time > 0.5 * d.time[-1] for d in est.data])
    owner = np.concatenate([np.full(d.time.size, i) for i, d in enumerate(est.data)])
    found = {
        "time": late,
        "the turn's side": r > 0.0,
        "yaw rate": np.abs(r) > np.median(np.abs(r)),
        "rudder angle": rudder > np.median(rudder),
    }
    if len(est.data) > 1:
        found |= {f"record {d.name}": owner == i for i, d in enumerate(est.data)}
    return {label: np.where(chosen, 1.0, -1.0) for label, chosen in found.items()}


def rate_statistic(est: Estimator, now: Innovations) -> float:
    """Standard score of squared innovations growing with the squares of their channels' rates of change."""
    total, variance = 0.0, 0.0
    for c in np.flatnonzero(est.channels):
        rates = []
        for i, d in enumerate(est.data):
            rows = slice(est.edges[i], est.edges[i + 1])
            rates.append(np.gradient(now.states[rows, est.layout[6 + c]], d.time))
        g = np.concatenate(rates) ** 2 * np.exp(-2.0 * now.log_s[:, c])
        used = now.e[:, c] != 0.0
        h = g[used] - g[used].mean()
        total += float(np.sum((np.minimum(now.e[used, c] ** 2, 20.0) - 1.0) * h))
        variance += 2.0 * float(np.sum(h**2))
    return total / np.sqrt(max(variance, 1e-300))


def whiteness_tests(est: Estimator, now: Innovations, lags: int = 12) -> list[tuple[str, float]]:
    """Log p-values of each channel's innovations being white over the first lags (Ljung-Box)."""
    from .evidence import log_tail

    out = []
    for c in np.flatnonzero(est.channels):
        total, count = np.zeros(lags), np.zeros(lags)
        for i in range(len(est.data)):
            e = np.clip(now.e[est.edges[i] + 10 : est.edges[i + 1], c], -4.5, 4.5)
            for k in range(1, lags + 1):
                total[k - 1] += e[k:] @ e[:-k]
                count[k - 1] += np.count_nonzero(e[k:] * e[:-k])
        if count.min() > 50:
            out.append((f"{SYMBOLS[c]} white", log_tail(float(np.sum(total**2 / count)), lags)))
    return out


def line_test(est: Estimator, now: Innovations) -> tuple[float, float]:
    """A spectral line in the innovations of heading, yaw rate and sway: log p and its angular frequency (rad/s)."""
    from scipy.stats import chi2

    from .evidence import log_tail

    best = (0.0, 1.0)
    dt = float(np.median(np.diff(est.data[0].time)))
    size = 4096
    omega = 2.0 * np.pi * np.fft.rfftfreq(size, dt)
    shortest = min(d.time[-1] for d in est.data)
    band = np.flatnonzero((omega > 2.0 * np.pi * 3.0 / shortest) & (omega < 0.3 * np.pi / dt))
    for c in np.flatnonzero(est.channels[:4]):
        power, runs = np.zeros(omega.size), 0
        for i in range(len(est.data)):
            e = np.clip(now.e[est.edges[i] + 6 : est.edges[i + 1], c], -4.5, 4.5)
            if np.count_nonzero(e) < 50:
                continue
            taper = np.hanning(e.size)
            power += np.abs(np.fft.rfft(e * taper, n=size)) ** 2 / np.sum(taper**2)
            runs += 1
        if not runs:
            continue
        median = float(chi2.median(2 * runs)) / 2.0
        background = [np.median(power[max(3, k - 80) : k + 80]) / median for k in band.tolist()]
        level = 2.0 * power[band] / np.maximum(background, 0.9)
        k = int(np.argmax(level))
        tests = 3.0 * shortest / dt / 4.0
        best = min(best, (log_tail(float(level[k]), 2 * runs) + np.log(tests), float(omega[band[k]])))
    return best
