"""What the filter's kernel takes and fills, grouped by what belongs together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import typeof, types

from ....models.compilation import I1, i8
from ....models.drivers import RHS

JACOBIAN = types.FunctionType(types.void(*[types.Array(types.float64, 1, "C")] * 6))


class FilterSizes(NamedTuple):
    """Sizes: states and parameters of the model, inputs, place of the first force and current input (-1: none),
    RK4 steps a sample, random forces."""

    n: int
    n_theta: int
    n_inputs: int
    first_force: int
    first_current: int
    substeps: int
    n_forces: int


class Recorded(NamedTuple):
    """One segment of a record.

    time, rudder, quiet (T,) as in `rudder_chain.run_chain`; other (T, no) inputs beside the rudder; environment (T, 4)
    recorded current and wind, north and east (m/s, towards); measured (T, 6) with nan gaps; start, variance (n,) of
    the states without a channel.
    """

    time: np.ndarray
    rudder: np.ndarray
    quiet: np.ndarray
    other: np.ndarray
    environment: np.ndarray
    measured: np.ndarray
    start: np.ndarray
    variance: np.ndarray


class Values(NamedTuple):
    """Numbers that the filter runs at.

    vector (NP,); force_unit (nf,); sensor_sd (6,); force_sd (nf,) in units; correlation_time (1,) s; added (T, nf + 6)
    forces and sensor shifts; rudder_error (2,) sd of the rudder's sensor, and share of the rudder's second difference
    that is error at a corner.
    """

    vector: np.ndarray
    force_unit: np.ndarray
    sensor_sd: np.ndarray
    force_sd: np.ndarray
    correlation_time: np.ndarray
    added: np.ndarray
    rudder_error: np.ndarray


class FilterRun(NamedTuple):
    """What is filled: whitened innovations and log S / 2 (T, 6) (0 at gaps), states (T, nx), predicted (T, 6)."""

    e: np.ndarray
    log_s: np.ndarray
    states: np.ndarray
    predicted: np.ndarray


class Trace(NamedTuple):
    """What derivatives need of a run; arrays without rows are not filled.

    transition (T, nx, nx) to the next sample; slopes (T, 6, nx) of the channels by the states, gains (T, 6, nx)
    covariances with them, roots (T, 6) 1 / sqrt S or 0; spreads (T, nf, nx) covariances of the forces after the
    sample; rates (T, 6) time derivatives of the channels' states.
    """

    transition: np.ndarray
    slopes: np.ndarray
    gains: np.ndarray
    roots: np.ndarray
    spreads: np.ndarray
    rates: np.ndarray


class Work(NamedTuple):
    """Model parameters and outer ones, states that are filtered (others are left out of the covariance), and the
    arrays that the steps of a sample work in."""

    theta: np.ndarray
    q: np.ndarray
    live: np.ndarray
    x: np.ndarray
    cov: np.ndarray
    phi: np.ndarray
    product: np.ndarray
    wave: np.ndarray
    slope: np.ndarray
    power: np.ndarray
    next_power: np.ndarray
    by_state: np.ndarray
    by_input: np.ndarray
    u: np.ndarray
    rate: np.ndarray
    probe: np.ndarray
    total: np.ndarray
    h: np.ndarray
    ph: np.ndarray
    force: np.ndarray
    late: np.ndarray
    back: np.ndarray


def signatures():
    """Types of the arguments of `_kernel.run_filter` and `_pushes.run_pushes`: one compiled version of each."""
    a = [np.zeros((1,) * d) for d in range(4)]
    shape = FilterSizes(*[1] * 7)
    recorded = Recorded(a[1], a[1], a[1], a[2], a[2], a[2], a[1], a[1])
    values = Values(a[1], a[1], a[1], a[1], a[1], a[2], a[1])
    run, trace = FilterRun(*[a[2]] * 4), Trace(a[3], a[3], a[3], a[2], a[3], a[2])
    kinds = [typeof(x) for x in (shape, recorded, values, run, trace)]
    models = RHS, JACOBIAN, kinds[0]
    a1, a2, a3 = (typeof(array) for array in a[1:])
    return (
        types.void(*models, I1, *kinds[1:3], i8, *kinds[3:]),
        types.void(*models, I1, *kinds[1:3], I1, a1, a2, a3),
    )
