"""States of a model from the velocities that a black box predicts: heading and positions by the trapezoidal rule."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....datasets.geometry import over_ground


def whole_run(names: Sequence[str], start: np.ndarray, outputs: dict[str, np.ndarray], dt: float) -> np.ndarray:
    """States (M + 1, n) `names` from start (n,) and outputs (M + 1,) by symbol, dt seconds apart."""
    count = len(next(iter(outputs.values())))
    known = dict(outputs)
    if "w" in names:
        known["w"] = np.gradient(known["r"], dt) if count > 1 else np.zeros(count)
    if "psi" in names:
        known["psi"] = _integral(known["r"], dt, start[names.index("psi")])
    if "x" in names:
        way = over_ground(known["u"], known["v"], known["psi"])
        known |= {s: _integral(rate, dt, start[names.index(s)]) for s, rate in (("x", way.real), ("y", way.imag))}
    return np.column_stack([known[name] for name in names])


def one_ahead(names: Sequence[str], states: np.ndarray, ahead: dict[str, np.ndarray], dt: float) -> np.ndarray:
    """States (N, n) one sample after each of states (N, n), from the outputs there (N,) by symbol."""
    now = dict(zip(names, states.T, strict=True))
    known = dict(ahead)
    if "w" in names:
        known["w"] = (ahead["r"] - now["r"]) / dt
    if "psi" in names:
        known["psi"] = now["psi"] + dt * (now["r"] + ahead["r"]) / 2.0
    if "x" in names:
        before = over_ground(now["u"], now["v"], now["psi"])
        moved = dt * (before + over_ground(ahead["u"], ahead["v"], known["psi"])) / 2.0
        known |= {"x": now["x"] + moved.real, "y": now["y"] + moved.imag}
    return np.column_stack([known[name] for name in names])


def _integral(rate: np.ndarray, dt: float, start: float) -> np.ndarray:
    return start + np.concatenate([[0.0], np.cumsum(dt * (rate[:-1] + rate[1:]) / 2.0)])
