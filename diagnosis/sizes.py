"""What a cause's parameters amount to: sizes in physical units with intervals, and which record they belong to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Estimator, Parameter, Setting
from .causes import CAUSES, Variant, drift_height
from .result import Size

NORMAL_90 = 1.6448536269514722
DRAWS = 2000
DESCRIBED = 1e-3
"""Share of a size by which it may be off because samples are joined and equations stepped: what the truth simulator's
records in calm show beyond the noise (107 sizes of the benchmark known to better than 1 %)."""


def sizes_of(
    est: Estimator, s: Setting, cause: str, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
) -> tuple[Size, ...]:
    """90 % intervals of a cause's sizes from the covariance (k, k) of its parameters.

    Speeds and directions come from draws of their components; limits from their share.
    """
    entry = CAUSES[cause]
    values = np.array([est.value(s, p) for p in variant])
    if cause == "wave_motion":
        return _waves(est, s)
    if cause == "clock_jitter":
        return _jitter(est, s)
    if entry.polar is not None:
        return _polar(est, entry.polar, cause, variant, values, covariance, rng)
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0) + (DESCRIBED * values) ** 2)
    halves = (NORMAL_90 * spread).tolist()
    return tuple(_plain(est, p, v, half) for p, v, half in zip(variant, values.tolist(), halves, strict=True))


def _plain(est: Estimator, p: Parameter, value: float, half: float) -> Size:
    low, high = max(value - half, p.low), min(value + half, p.high)
    name = None if p.record is None else est.data[p.record].name
    own, unit = p.name.partition(":")[0], p.unit
    shift = {"recovery": est.base[est.index["loss_time"]] if "loss_time" in est.index else 0.0}
    shift |= {"T2": est.base[est.index["lead_T2"]] if "lead_T2" in est.index else 0.0}
    shift |= {"power": est.base[est.index["loss_power"]] if "loss_power" in est.index else 0.0}
    add = shift.get(own, 0.0)
    if own == "draught_over_depth":
        ratio = [1.0 / max(x, 1e-3) for x in (value, high, low)]
        return Size("depth_ratio", ratio[0], ratio[1], ratio[2], "1", name)
    return Size(own, value + add, low + add, high + add, unit, name)


def _polar(est, polar, cause, variant, values, covariance, rng) -> tuple[Size, ...]:
    out = []
    for i in range(0, len(variant), 2):
        pair = values[i : i + 2]
        block = covariance[i : i + 2, i : i + 2] + DESCRIBED**2 * (pair @ pair) * np.eye(2)
        draws = pair + rng.multivariate_normal(np.zeros(2), block, DRAWS, method="eigh")
        sign = -1.0 if polar.coming_from and cause == "wind" else 1.0
        direction = float(np.arctan2(sign * pair[1], sign * pair[0]))
        turned = np.arctan2(sign * draws[:, 1], sign * draws[:, 0]) - direction
        turned = np.mod(turned + np.pi, 2.0 * np.pi) - np.pi
        low, high = np.quantile(turned, [0.05, 0.95])
        speed = float(np.hypot(*pair))
        along = draws @ pair / max(speed, 1e-300)
        ends = np.maximum(np.quantile(along, [0.05, 0.95]), 0.0)
        if cause == "wave_drift":
            speed, ends = drift_height(est, speed), np.array([drift_height(est, x) for x in ends])
        name = est.data[variant[i].record].name if variant[i].record is not None else None
        unit = "m" if cause == "wave_drift" else "m/s"
        out.append(Size(polar.speed, speed, float(ends[0]), float(ends[1]), unit, name))
        out.append(Size(polar.direction, direction, direction + float(low), direction + float(high), "rad", name))
    return tuple(out)


def _jitter(est: Estimator, s: Setting) -> tuple[Size, ...]:
    """The clock's error with the interval that the likelihood in its logarithm gives.

    One sample's channels share its error and tell of it together: spread of the samples' scores over curvature.
    """
    index, h = est.index["clock"], 0.05
    value = float(s.p[0, index])
    ll = []
    for factor in (np.exp(-h), 1.0, np.exp(h)):
        p = s.p.copy()
        p[:, index] = value * factor
        now = est.evaluate(replace(s, p=p))
        ll.append(-np.sum(now.log_s + 0.5 * now.e**2, axis=1))
    curvature = max(-float(np.sum(ll[0] - 2.0 * ll[1] + ll[2])) / h**2, 1.0)
    half = NORMAL_90 * float(np.linalg.norm((ll[2] - ll[0]) / (2.0 * h))) / curvature
    return (Size("sd", value, value * float(np.exp(-half)), value * float(np.exp(half)), "s"),)


def _waves(est: Estimator, s: Setting) -> tuple[Size, ...]:
    """Frequency, damping and rms, of all records or each, with intervals from the curvature of the likelihood."""
    names = {"omega": ("wave_frequency", "rad/s"), "damping": ("wave_damping", "1"), "rms": ("wave_rms", "rad")}
    slots = [est.index[slot] for slot, _ in names.values()]
    shared = bool(np.all(s.p[:, slots] == s.p[0, slots]))
    out = []
    for owner in [None] if shared else range(len(est.data)):
        values = s.p[owner or 0, slots]
        half = NORMAL_90 * np.sqrt(np.diag(_wave_covariance(est, s, slots, owner)))
        label = None if owner is None else est.data[owner].name
        out += [
            Size(name, float(v), float(v * np.exp(-w)), float(v * np.exp(w)), unit, label)
            for (name, (_, unit)), v, w in zip(names.items(), values, half, strict=True)
        ]
    return tuple(out)


def _wave_covariance(est: Estimator, s: Setting, slots: list[int], owner: int | None) -> np.ndarray:
    """Covariance (3, 3) of the logarithms of frequency, damping and rms, the noise held."""
    h = np.array([0.02, 0.1, 0.05])
    rows, some = (slice(None), None) if owner is None else (owner, [owner])

    def likelihood(step: np.ndarray) -> float:
        p = s.p.copy()
        p[rows, slots] *= np.exp(step)
        return est.evaluate(replace(s, p=p), some).log_likelihood

    steps = np.diag(h)
    middle = likelihood(np.zeros(3))
    hessian = np.zeros((3, 3))
    for i in range(3):
        up, down = likelihood(steps[i]), likelihood(-steps[i])
        hessian[i, i] = -(up - 2.0 * middle + down) / h[i] ** 2
        for j in range(i):
            mixed = likelihood(steps[i] + steps[j]) - likelihood(steps[i] - steps[j])
            mixed += likelihood(-steps[i] - steps[j]) - likelihood(steps[j] - steps[i])
            hessian[i, j] = hessian[j, i] = -mixed / (4.0 * h[i] * h[j])
    value, axes = np.linalg.eigh(hessian)
    return axes @ np.diag(1.0 / np.maximum(value, 1.0)) @ axes.T
