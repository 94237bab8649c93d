"""Measured and simulated channels of one record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Trace:
    """One record for the page: measured channels against the free runs before and after.

    time (T,) s; measured, before, after: channel name -> (T,), SI; nan where not scored.
    """

    record: str
    role: str
    time: np.ndarray
    rudder: np.ndarray
    measured: dict[str, np.ndarray]
    before: dict[str, np.ndarray]
    after: dict[str, np.ndarray]
