"""The compiled loop of a run that is restarted at the measurements."""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, I1, JIT, b1, f8, i8, njit

SIMULATE = types.FunctionType(types.void(A1, A2, A1, f8, i8, b1, A2))


@njit(inline="always")
def count_near(run, skipped, measured, first, columns, far):
    """Leading rows of a run, its first `skipped` apart, that are finite and near the measurements from row `first`."""
    for i in range(skipped, run.shape[0]):
        for c in range(columns.size):
            column = columns[c]
            here, there = run[i, column], measured[first + i - skipped, column]
            if not np.isfinite(here) or (np.isfinite(there) and abs(here - there) > far[c]):
                return i - skipped
        for j in range(run.shape[1]):
            if not np.isfinite(run[i, j]):
                return i - skipped
    return run.shape[0] - skipped


@njit(types.void(SIMULATE, A1, A2, A1, f8, i8, A2, I1, A1, i8, i8, A2), **JIT)
def restarted(simulate, start, inputs, theta, step, count, measured, columns, far, length, shortest, states):
    """Fill `states` (M, n): a run that starts anew at the measurements every `length` samples and where it is far off.

    A run is simulated in pieces, the first of `shortest` samples and each twice as long as the one before, so that the
    cost stays linear in the number of samples however often the run is restarted.

    simulate : the model's kernel.
    inputs : (M, nu);  step, count : integration step, s, and how many make a sample.
    measured : (M, n), nan where nothing is measured;  columns, far : measured states and the error that counts as far.
    """
    m, state = len(inputs), start.copy()
    ahead = np.empty((m + 1, start.size))
    first = 0
    while first < m:
        n = min(length, m - first)
        piece, done, found = shortest, 0, 0
        while done < n:
            stop, skipped = min(done + piece, n), min(done, 1)
            before = first + done - skipped
            run = ahead[: stop - done + skipped]
            simulate(
                state if done == 0 else states[before], inputs[before : first + stop], theta, step, count, False, run
            )
            near = count_near(run, skipped, measured, first + done, columns, far)
            states[first + done : first + done + near] = run[skipped : skipped + near]
            found = done + near
            if near < stop - done:
                break
            done, piece = stop, 2 * piece
        if found == 0:
            states[first] = state
            found = 1
        state = states[first + found - 1].copy()
        first += found
        if first < m:
            for j in range(state.size):
                if np.isfinite(measured[first, j]):
                    state[j] = measured[first, j]
                elif not np.isfinite(state[j]):
                    state[j] = 0.0
