"""Derivatives of a filter's whitened innovations, carried along a run that `_kernel` has stored.

With its transitions, slopes and gains held a run is linear: the response to a forcing is a recursion of the states'
shift, and that to a variance of the noise one of their covariance.
"""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, A3, BORROWED, I1, JIT, f8, i8, njit
from .vector import CHANNELS

BLOCK = 128
"""Columns that are carried at a time."""
FORCES = 4
"""Places for the variances of up to three forces and their correlation time."""
LANES = FORCES + CHANNELS
"""Places for them and for the log standard deviations of the sensors."""


@njit(inline="always")
def _seen(k, c, start, width, slopes, gains, roots, nf, axes, held, shift, seen, out, place):
    """Response of one innovation, and the shift's correction by it."""
    root = roots[k, c]
    if root == 0.0:
        return
    nx, block = shift.shape
    for b in range(block):
        seen[b] = 0.0
    for j in range(nx):
        weight = slopes[k, c, j]
        if weight != 0.0:
            for b in range(block):
                seen[b] += weight * shift[j, b]
    for b in range(width):
        if axes[start + b] == nf + c:
            seen[b] += held[b]
        out[start + b, place] = -seen[b] * root
    for j in range(nx):
        weight = gains[k, c, j] * root * root
        if weight != 0.0:
            for b in range(block):
                shift[j, b] -= weight * seen[b]


@njit(**JIT, **BORROWED)
def _blocks(
    transition, slopes, gains, roots, n, nf, axes, forcing, pushes, initial, first, out, shift, moved, held, seen
):  # fmt: skip
    """Block after block of the columns of `carry`; the last arrays are working space."""
    size, (nx, block) = transition.shape[0], shift.shape
    for start in range(0, axes.size, BLOCK):
        width = min(axes.size - start, BLOCK)
        shift[:] = 0.0
        for b in range(width):
            for i in range(n):
                shift[i, b] = initial[start + b, i]
        for k in range(size):
            for b in range(width):
                held[b] = forcing[start + b, k]
            for c in range(CHANNELS):
                place = (first + k) * CHANNELS + c
                _seen(k, c, start, width, slopes, gains, roots, nf, axes, held, shift, seen, out, place)
            for i in range(nx):
                for b in range(block):
                    moved[i, b] = 0.0
                for j in range(nx):
                    weight = transition[k, i, j]
                    if weight != 0.0:
                        for b in range(block):
                            moved[i, b] += weight * shift[j, b]
            for b in range(width):
                axis = axes[start + b]
                if held[b] != 0.0 and axis < nf:
                    for i in range(n):
                        moved[i, b] += transition[k, i, n + axis] * held[b]
                elif axis >= nf + CHANNELS:
                    for i in range(n):
                        moved[i, b] += pushes[k, axis - nf - CHANNELS, i] * held[b]
            shift, moved = moved, shift


@njit(types.void(A3, A3, A3, A2, i8, i8, I1, A2, A3, A2, i8, A2), **JIT)
def carry(transition, slopes, gains, roots, n, nf, axes, forcing, pushes, initial, first, out):
    """Responses of the whitened innovations to forcing, the gains held.

    transition (T, nx, nx), slopes, gains (T, 6, nx), roots (T, 6) of a run with n states and nf forces; axes (m,):
    < nf a force in units, then channel axis - nf, then the push of the states pushes[:, axis - nf - 6] (T, n); forcing
    (m, T) their sizes; initial (m, n) shift of the first state.  Filled: out (m, N * 6), from sample `first` on.
    """
    nx, block = transition.shape[1], min(BLOCK, axes.size)
    shift, moved = np.zeros((nx, block)), np.zeros((nx, block))
    held, seen = np.zeros(block), np.zeros(block)
    _blocks(
        transition, slopes, gains, roots, n, nf, axes, forcing, pushes, initial, first, out, shift, moved, held, seen
    )  # fmt: skip


@njit(inline="always")
def _measured(root, e, slope, gain, own_variance, lane, shift, part, spread, even, scaled, ds, dnu, by_e, by_log_s, at):
    """Derivatives of one innovation and its variance; the changes of states and covariance after its update."""
    nx, wide = shift.shape[0], spread.size
    inverse, nu = root * root, e / root
    for j in range(wide):
        spread[j] = 0.0
    for b in range(LANES):
        ds[b], dnu[b] = 0.0, 0.0
    for j in range(nx):
        w = slope[j]
        if w != 0.0:
            for i in range(wide):
                spread[i] += w * part[j, i]
            for i in range(nx):
                for b in range(LANES):
                    spread[i * LANES + b] += w * part[i, j * LANES + b]
            for b in range(LANES):
                dnu[b] -= w * shift[j, b]
    for j in range(nx):
        w = slope[j]
        if w != 0.0:
            for b in range(LANES):
                ds[b] += w * spread[j * LANES + b]
    ds[lane] += 2.0 * own_variance
    for b in range(LANES):
        by_e[b, at] = dnu[b] * root - 0.5 * e * ds[b] * inverse
        by_log_s[b, at] = 0.5 * ds[b] * inverse
    for i in range(nx):
        scaled[i] = gain[i] * inverse
        for b in range(LANES):
            own = spread[i * LANES + b]
            even[i * LANES + b] = own - 0.5 * scaled[i] * ds[b]
            shift[i, b] += (own - scaled[i] * ds[b]) * nu * inverse + scaled[i] * dnu[b]
    for i in range(nx):
        w = scaled[i]
        for j in range(wide):
            part[i, j] -= w * even[j]


@njit(inline="always")
def _moved(transition, shift, moved, part, half, turned):
    """Changes of states (in `moved`) and covariance (in `part`) carried to the next sample."""
    nx, wide = shift.shape[0], part.shape[1]
    for i in range(nx):
        for b in range(LANES):
            moved[i, b] = 0.0
        for j in range(wide):
            half[i, j] = 0.0
        for j in range(nx):
            w = transition[i, j]
            if w != 0.0:
                for b in range(LANES):
                    moved[i, b] += w * shift[j, b]
                for j2 in range(wide):
                    half[i, j2] += w * part[j, j2]
    for i in range(nx):
        for j in range(nx):
            for b in range(LANES):
                turned[j, i * LANES + b] = half[i, j * LANES + b]
    for i in range(nx):
        for j in range(wide):
            part[i, j] = 0.0
        for j in range(nx):
            w = transition[i, j]
            if w != 0.0:
                for j2 in range(wide):
                    part[i, j2] += w * turned[j, j2]


@njit(**JIT, **BORROWED)
def _along(
    transition, slopes, gains, roots, spreads, whitened, states, time, sensor_sd, force_sd, tau, n, nf, quantum, first,
    by_e, by_log_s, shift, moved, part, half, turned, spread, even, scaled, ds, dnu,
):  # fmt: skip
    """Sample after sample of `vary`; the last arrays are working space."""
    size, nx = transition.shape[0], transition.shape[1]
    for k in range(size):
        for c in range(CHANNELS):
            if roots[k, c] != 0.0:
                at = (first + k) * CHANNELS + c
                _measured(
                    roots[k, c], whitened[k, c], slopes[k, c], gains[k, c], sensor_sd[c] ** 2, FORCES + c, shift, part,
                    spread, even, scaled, ds, dnu, by_e, by_log_s, at,
                )  # fmt: skip
        if k == size - 1:
            break
        _moved(transition[k], shift, moved, part, half, turned)
        dt = time[k + 1] - time[k]
        decay = np.exp(-dt / tau)
        slower = decay * dt / tau
        for i in range(nf):
            moved[n + i, FORCES - 1] += slower * states[k, n + i]
            for j in range(nx):
                w = 0.0
                for j2 in range(nx):
                    w += spreads[k, i, j2] * transition[k, j, j2]
                part[n + i, j * LANES + FORCES - 1] += slower * w
            own = (n + i) * LANES
            part[n + i, own + i] += 0.5 * quantum**2 * (1.0 - decay * decay)
            part[n + i, own + FORCES - 1] -= slower * decay * force_sd[i] ** 2
        shift, moved = moved, shift


@njit(types.void(A3, A3, A3, A2, A3, A2, A2, A1, A1, A1, f8, i8, f8, i8, A2, A2), **JIT)
def vary(
    transition, slopes, gains, roots, spreads, whitened, states, time, sensor_sd, force_sd, tau, n, quantum, first,
    by_e, by_log_s,
):  # fmt: skip
    """Derivatives of innovations and log S / 2 by the forces' variances (in quanta^2) and their log correlation time,
    and by the log standard deviations of the sensors.

    transition (T, nx, nx), slopes, gains (T, 6, nx), roots (T, 6), spreads (T, nf, nx), whitened (T, 6),
    states (T, nx) of a run; sensor_sd (6,), force_sd (nf,) and correlation time tau of the noise.  Filled: by_e,
    by_log_s (LANES, N * 6) from sample `first` on, rows 0..nf - 1 the variances, row FORCES - 1 the time, the last six
    the sensors.  Left out: how the model's slopes change with its states, and the variance of the first state with the
    sensors.
    """
    nx, nf = transition.shape[1], spreads.shape[1]
    wide = nx * LANES
    shift, moved = np.zeros((nx, LANES)), np.zeros((nx, LANES))
    # the covariance's change is part + its transpose: one half of each symmetric update
    part, half, turned = np.zeros((nx, wide)), np.zeros((nx, wide)), np.zeros((nx, wide))
    spread, even, scaled = np.zeros(wide), np.zeros(wide), np.zeros(nx)
    ds, dnu = np.zeros(LANES), np.zeros(LANES)
    for i in range(nf):
        part[n + i, (n + i) * LANES + i] = 0.5 * quantum**2
    _along(
        transition, slopes, gains, roots, spreads, whitened, states, time, sensor_sd, force_sd, tau, n, nf, quantum,
        first, by_e, by_log_s, shift, moved, part, half, turned, spread, even, scaled, ds, dnu,
    )  # fmt: skip
