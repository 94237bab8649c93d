"""Levels that all selections share: of significance, of ties."""

from __future__ import annotations

import numpy as np

FIRST, LATER, UNMODELLED = 0.5, 0.2, 0.3
"""How the family-wise level is spent: first cause, later ones, effects outside the bank."""
TESTS = 25.0
"""Independent tests that the bank amounts to, where they are not counted."""
LEADERS = 4
"""Most screened causes that are refitted: of 83 injected effects and the stronger ones of 27 pairs all that were
significant stood among the first four; what another hides is screened again beside that one."""
TIE_NATS, MOST_TIED = 4.6, 2
"""Log p-values within which significant rivals are tied, and how many are named beside the best."""


def adjusted(log_p: float, tests: float = TESTS) -> float:
    """A p-value adjusted for independent tests."""
    return float(min(1.0, tests * np.exp(max(log_p, -700.0))))
