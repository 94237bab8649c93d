"""Errors of free runs in blocks of time, and the ratio of two models' errors with its interval."""

from __future__ import annotations

import numpy as np

BLOCK_S = 20.0
"""Length of a block, s of a 160 m ship: errors of different blocks count as independent."""
DRAWS = 1000


def error_blocks(error: np.ndarray, size: int) -> list[tuple[float, int]]:
    """Sum of squares and number of the errors (n,) that are known, of each block of `size`."""
    parts = [error[i : i + size] for i in range(0, error.size, size)]
    return [(float(np.nansum(p**2)), int(np.isfinite(p).sum())) for p in parts]


def ratio_of(old: np.ndarray, new: np.ndarray, rng: np.random.Generator) -> tuple[float, float, float]:
    """Ratio of the rms errors new over old, of blocks (B, 2), with its 90 % interval by a block bootstrap."""
    pick = rng.integers(0, len(old), (DRAWS, len(old)))
    ratios = np.sqrt(new[pick, 0].sum(axis=1) / np.maximum(old[pick, 0].sum(axis=1), 1e-300))
    low, high = np.quantile(ratios, [0.05, 0.95])
    whole = np.sqrt(new[:, 0].sum() / max(old[:, 0].sum(), 1e-300))
    return float(whole), float(low), float(high)
