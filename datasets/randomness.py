"""Random streams with stable names, and the coloured noise process of gusts and sensors."""

from __future__ import annotations

import hashlib
import secrets

import numpy as np

from ..models.plain import EXACT_BELOW


def drawn_seed() -> int:
    """A new seed, 0 to 2**53 - 1, that nobody can guess: for what is drawn where the user gave no seed."""
    return secrets.randbelow(EXACT_BELOW)


def stable_hash(*names: str) -> int:
    """A 128-bit integer from texts, the same in every process and on every machine."""
    digest = hashlib.sha256("\x1f".join(names).encode()).digest()
    return int.from_bytes(digest[:16], "little")


def stream(seed: int, *names: str) -> np.random.Generator:
    """Generator of its own for ``(seed, names)``: what other streams draw does not change it."""
    return np.random.default_rng(np.random.SeedSequence([seed, stable_hash(*names)]))


def key_of(rng: np.random.Generator) -> int:
    """One draw from ``rng`` that seeds named sub-streams (`stream`) of one caller."""
    return int(rng.integers(0, 2**63))


def gauss_markov(time_s: np.ndarray, sd: float, correlation_s: float, rng: np.random.Generator) -> np.ndarray:
    """Stationary first-order Gauss-Markov process at times ``time_s`` (N,), sampled exactly.

    Autocovariance ``sd**2 exp(-|lag| / correlation_s)``; correlation time 0 gives white noise.
    The time steps may differ. (Gelb, Applied Optimal Estimation, 1974, sec 3.8.)
    """
    shocks = rng.standard_normal(time_s.size)
    if correlation_s <= 0.0 or time_s.size == 0:
        return sd * shocks
    decay = np.exp(-np.diff(time_s) / correlation_s)
    kick = np.sqrt(1.0 - decay**2) * shocks[1:]
    value = float(shocks[0])
    out = [value]
    for a, b in zip(decay.tolist(), kick.tolist(), strict=True):
        value = a * value + b
        out.append(value)
    return sd * np.array(out)
