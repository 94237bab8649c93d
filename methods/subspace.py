"""Linear state-space model by a subspace method: order from a projection, input matrices from free runs.

With the scaled signals of `black_box.state_space`,

    x(t + h) = A x(t) + B w(t) + c,    z(t + h) = C x(t) + D w(t) + d,    x(t) = M p(t) + m

Extended observability matrix: left singular vectors of the part of the future outputs that the past explains beyond the
future inputs.  A by its shift invariance; B, D, c, d by least squares on free runs; M and m by least squares on the
states that explain the future best.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.rows import Signals, whole_places
from ..estimation.methods_only.black_box.state_space import Training, pasts, training_of
from ..estimation.methods_only.tuning.space import Integer
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.linear_algebra import lstsq, ridge, svd
from ..models.model import Model
from .base import method
from .learner import STRIDE, Learner, open_option


@method("subspace", "linear state space by a subspace method (MOESP)", Learner)
def Subspace(
    records: Sequence[Record],
    model: Model,
    stride: int | None = STRIDE,
    order: int | None = open_option("number of states x", Integer(1, 8), 2),
) -> Fit:
    """Linear state-space model of velocities and yaw rate by a subspace method (PO-MOESP).

        x(t + h) = A x(t) + B w(t) + c,    z(t + h) = C x(t) + D w(t) + d

    The subspace of the states is what the past explains of the future outputs beyond the future inputs; B and D follow
    by least squares on free runs.  Eigenvalues of A outside the unit circle are reflected into it.  Sources: Verhaegen
    1994, Automatica 30(1), 61; Ljung 1999, System Identification, section 10.6.  The order is chosen by free runs, not
    by a gap of singular values.
    """
    training = training_of(records, model, int(stride or 1))
    return training.fit(*identify(training, int(order or 1)))


RIDGE = 1e-8
"""Penalty of the least-squares problems relative to the mean square of a column."""


class LinearSystem(NamedTuple):
    """State (z, x), see `state_space.System`: x has n entries, z k, inputs nu, pasts q entries.

    Parameters
    ----------
    a, b, c, d : (n, n), (n, nu), (k, n), (k, nu).
    offset : (k + n,) of z and x.
    from_past : (n, q); from_past_offset : (n,).
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    offset: np.ndarray
    from_past: np.ndarray
    from_past_offset: np.ndarray

    def begin(self, past: np.ndarray) -> np.ndarray:
        """States (N, k + n) after pasts (N, q)."""
        return np.hstack([past[:, : len(self.c)], past @ self.from_past.T + self.from_past_offset])

    def advance(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """States (N, k + n) one step on under inputs (N, nu)."""
        x = state[:, len(self.c) :]
        return np.hstack([x @ self.c.T + inputs @ self.d.T, x @ self.a.T + inputs @ self.b.T]) + self.offset


def identify(training: Training, order: int) -> tuple[LinearSystem, int]:
    """The system of `order` states and the number of steps of its pasts.

    Raises
    ------
    CannotFit : there are no more samples than unknowns.
    FitFailed : no finite system is found.
    """
    k = training.parts[0].outputs.shape[1]
    steps = 2 * -(-order // k) + 2
    past, inputs, outputs = _rows(training, steps)
    try:
        gamma = _observability(past, inputs, outputs, order)
        a, c = _stable(lstsq(gamma[:-k], gamma[k:])), gamma[:k]
        b, d, offset = _input_matrices(training, a, c)
        system = LinearSystem(a, b, c, d, offset, np.zeros((order, past.shape[1])), np.zeros(order))
        system = LinearSystem(*map(np.ascontiguousarray, _with_start(system, past, inputs, outputs)))
    except np.linalg.LinAlgError as error:
        raise FitFailed(f"no linear system of order {order}: {error}") from error
    if not all(np.isfinite(part).all() for part in system):
        raise FitFailed(f"no finite linear system of order {order}")
    return system, steps


def _rows(training: Training, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pasts (N, q), future inputs (N, f nu) and outputs (N, f k) of samples with `steps` whole steps on both sides."""
    s, found = training.stride, []
    for part in training.parts:
        place = whole_places(part.whole, s * steps, s * steps)
        if place.size:
            ahead = place[:, None] + s * np.arange(steps + 1)
            w, z = part.inputs[ahead[:, :-1]], part.outputs[ahead[:, 1:]]
            found.append((pasts(part, place, s, steps), w.reshape(len(place), -1), z.reshape(len(place), -1)))
    n = sum(len(past) for past, _, _ in found)
    k, nu = training.parts[0].outputs.shape[1], training.parts[0].inputs.shape[1]
    unknowns = steps * (k + 2 * nu) + 1
    if n <= unknowns:
        raise CannotFit(f"{n} usable rows for {unknowns} unknowns")
    past, inputs, outputs = (np.vstack(blocks) for blocks in zip(*found, strict=True))
    return past, inputs, outputs


def _observability(past: np.ndarray, inputs: np.ndarray, outputs: np.ndarray, order: int) -> np.ndarray:
    """Extended observability matrix (f k, n)."""
    first = np.hstack([np.ones((len(past), 1)), inputs])
    r = np.asarray(np.linalg.qr(np.hstack([first, past, outputs]), mode="r"))
    start, end = first.shape[1], first.shape[1] + past.shape[1]
    u, size, _ = svd(r[start:end, end:].T, full_matrices=False)
    return u[:, :order] * np.sqrt(size[:order])


def _stable(a: np.ndarray) -> np.ndarray:
    """The matrix (n, n) with eigenvalues outside the unit circle reflected into it."""
    values, vectors = np.linalg.eig(a)
    if np.abs(values).max() <= 1.0:
        return a
    return np.real(np.linalg.solve(vectors.T, (vectors * (values / np.maximum(np.abs(values), 1.0) ** 2)).T).T)


def _input_matrices(training: Training, a: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B (n, nu), D (k, nu) and offsets (k + n,), with the first states of the records as further unknowns."""
    n, k, nu = len(a), len(c), training.parts[0].inputs.shape[1]
    blocks, targets, own = [], [], []
    for part in training.parts:
        place = np.arange(0, len(part.whole), training.stride)
        known = part.whole[place[1:]]
        forced, free = _responses(part, place, a)
        direct = np.hstack([part.inputs[place[:-1]], np.ones((len(place) - 1, 1))])
        through = _by_unit_matrices(direct, k)
        blocks.append(np.concatenate([c @ forced, through], axis=2)[known].reshape(-1, (n + k) * (nu + 1)))
        own.append((c @ free)[known].reshape(-1, n))
        targets.append(part.outputs[place[1:]][known].ravel())
    starts = np.zeros((sum(map(len, own)), n * len(own)))
    row = 0
    for number, block in enumerate(own):
        starts[row : row + len(block), n * number : n * (number + 1)] = block
        row += len(block)
    found = _least_squares(np.hstack([np.vstack(blocks), starts]), np.concatenate(targets)[:, None])[:, 0]
    x = found[: n * (nu + 1)].reshape(nu + 1, n)
    z = found[n * (nu + 1) : (n + k) * (nu + 1)].reshape(nu + 1, k)
    return x[:nu].T, z[:nu].T, np.concatenate([z[nu], x[nu]])


def _responses(part: Signals, place: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States before each step by unit entries of (B, c): (T, n, n (nu + 1)); by unit first states: (T, n, n)."""
    n = len(a)
    driven = np.hstack([part.inputs[place[:-1]], np.ones((len(place) - 1, 1))])
    forced, free = np.zeros((len(driven), n, n * driven.shape[1])), np.zeros((len(driven), n, n))
    pushed = _by_unit_matrices(driven, n)
    state, power = forced[0], np.eye(n)
    for step in range(len(driven)):
        forced[step], free[step] = state, power
        state = a @ state + pushed[step]
        power = a @ power
    return forced, free


def _by_unit_matrices(inputs: np.ndarray, n: int) -> np.ndarray:
    """What inputs (T, j) give by unit entries of a matrix (n, j): (T, n, j n)."""
    return np.einsum("tj,ci->tcji", inputs, np.eye(n)).reshape(len(inputs), n, -1)


def _least_squares(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Coefficients (p, m) of columns x (N, p) for y (N, m), with a small penalty."""
    size = np.sqrt(np.mean(x**2, axis=0))
    size[size == 0.0] = 1.0
    return ridge(x / size, y, np.sqrt(RIDGE * len(x))) / size[:, None]


def _with_start(system: LinearSystem, past: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> LinearSystem:
    """The system with M and m: states that explain the future outputs best, regressed on the past."""
    n, nu = system.b.shape
    k, steps = len(system.c), inputs.shape[1] // nu
    state = np.zeros((len(past), k + n))
    forced, gamma, power = [], [], np.eye(n)
    for step in range(steps):
        state = system.advance(state, inputs[:, nu * step : nu * (step + 1)])
        forced.append(state[:, :k])
        gamma.append(system.c @ power)
        power = system.a @ power
    best = _least_squares(np.vstack(gamma), (outputs - np.hstack(forced)).T).T
    found = _least_squares(np.hstack([past, np.ones((len(best), 1))]), best)
    return system._replace(from_past=found[:-1].T, from_past_offset=found[-1])
