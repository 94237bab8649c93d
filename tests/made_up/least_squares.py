"""Least-squares problems of the methods' tests: columns of very different sizes."""

import numpy as np

from helmbench.estimation.numerics import factors


def factor_of(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The triangular factor of a matrix (N, m) and a right-hand side (N,)."""
    return factors.fold(factors.empty(a.shape[1]), np.column_stack([a, b]))


def problem(rng: np.random.Generator, n: int = 300, m: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """A matrix (n, m), and numbers (m,) whose products with its columns are of one size."""
    a = rng.normal(size=(n, m)) * np.logspace(-3, 3, m)
    x = rng.normal(size=m) / np.logspace(-3, 3, m)
    return a, x
