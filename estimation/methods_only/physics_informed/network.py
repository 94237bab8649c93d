"""Local networks of time, the hidden layer spread over a window of a record.

Within a window the states are

    x(t) = m + s (sum_k W_k tanh(SLOPE (t - c_k) / h) + W_0 + sum_j V_j g_j(t)),    g_j(t) = integral of u(t)^j

with units at equal distances h, so that each is the transition of one short stretch of time.  A network whose units
begin at random learns a record of many zigzag legs only in its lowest frequencies; the spread of Nguyen & Widrow 1990
(Proc. IJCNN, 3, 21) has all that the distance h allows from the beginning.  The integrals of powers of the inputs are
features of time too: the rudder is known, and where its rate jumps, so does the slope of an acceleration, which smooth
units would need many of.  The hidden layer stays as it is and the output weights W, V are trained: a physics-informed
extreme learning machine (Dwivedi & Srinivasan 2020, Neurocomputing 391, 96).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SLOPE = 0.8
"""Slope of a unit per distance of units: the sum of the slopes of all is level to 1e-4."""
BEYOND = 1.5
"""Distance to which units lie outside the window, in steps."""
POWERS = 3
"""Powers of the inputs whose integrals are features."""


class Features(NamedTuple):
    """The hidden layer at T times: values (T, f) and slopes (T, f), 1/s."""

    values: np.ndarray
    slopes: np.ndarray


def features_of(window: tuple[int, int, int], dt: float, inputs: np.ndarray, place: np.ndarray) -> Features:
    """The hidden layer of a window.

    Parameters
    ----------
    window : first and last row of the series' grid, and the number of its units.
    inputs : (M + 1, nu) of the whole grid, in units of their size, dt seconds apart and linear in between.
    place : (T,) times in grid steps.
    """
    first, last, units = window
    distance = (last - first + 2.0 * BEYOND) / max(units - 1, 1)
    centre = np.linspace(first - BEYOND, last + BEYOND, units)
    bend = np.tanh(SLOPE / distance * (place[:, None] - centre))
    rise = SLOPE / (distance * dt) * (1.0 - bend**2)
    grid = np.arange(first, last + 1)
    part = inputs[first : last + 1]
    sums, powers = _integrals(part), _powers(part)
    known = np.column_stack([np.interp(place, grid, column) for column in sums.T]) / distance
    slopes = np.column_stack([np.interp(place, grid, column) for column in powers.T]) / (distance * dt)
    one = np.ones((len(place), 1))
    return Features(np.hstack([bend, one, known]), np.hstack([rise, 0.0 * one, slopes]))


def _powers(inputs: np.ndarray) -> np.ndarray:
    """u, u^2, ... (M + 1, POWERS nu)."""
    return np.hstack([inputs**power for power in range(1, POWERS + 1)])


def _integrals(inputs: np.ndarray) -> np.ndarray:
    """Their integrals over the grid, per step, (M + 1, POWERS nu): exact at the grid for inputs linear in between."""
    a, b = inputs[:-1], inputs[1:]
    means = [sum(a**i * b ** (power - i) for i in range(power + 1)) / (power + 1) for power in range(1, POWERS + 1)]
    return np.vstack([np.zeros((1, POWERS * inputs.shape[1])), np.cumsum(np.hstack(means), axis=0)])
