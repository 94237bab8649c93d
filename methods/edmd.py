"""Extended dynamic mode decomposition with control: outputs lifted to monomials, which move on linearly.

With the scaled signals of `black_box.state_space` and q(t) = z(t), z(t - h), ..., z(t - (l - 1) h),

    g(q) = (q, their products of 2 to `degree` factors),    g(q(t + h)) = A g(q(t)) + B p(t) + c

by ridge regression over all whole steps.  p are the inputs w and, in the bilinear form, their products with every entry
of g as well (Bruder, Fu & Vasudevan 2021, IEEE Robot. Autom. Lett. 6(3), 4416).  The first k entries of the state are
the outputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.rows import whole_places
from ..estimation.methods_only.black_box.state_space import Training, pasts, training_of
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit
from ..models.model import Model
from .base import method
from .learner import LAGS, STRIDE, Learner, open_option
from .options import option


@method("edmd", "linear model of lifted outputs (EDMD with control, Koopman)", Learner)
def Edmd(
    records: Sequence[Record],
    model: Model,
    stride: int | None = STRIDE,
    degree: int | None = open_option("of the products, 1, 2 or 3", Integer(1, 3), 1),
    output_lags: int | None = open_option("values of the outputs that are lifted", LAGS, 1),
    alpha: float | None = open_option("ridge penalty", Real(1e-9, 1e-1, log=True), 1e-6),
    bilinear: bool = option(True, "whether products of inputs and lifted outputs act too"),
) -> Fit:
    """Extended dynamic mode decomposition with control (EDMDc), a finite approximation of the Koopman operator.

        g(z(t + h)) = A g(z(t)) + B w(t) + c

    g(z) are velocities, yaw rate and their products up to a degree, also of earlier steps; A, B and c follow by ridge
    regression.  A free run moves the lifted state on linearly and computes no product anew: this makes it a Koopman
    model, and `narx-poly` none.  With degree=1 it is dynamic mode decomposition with control (DMDc).  Inputs act
    linearly: what a rudder does in proportion to the state, such as the loss of speed in a turn, has no place in this
    form.  A is not made stable: options whose free runs diverge are not chosen.  Sources: Proctor, Brunton & Kutz 2016,
    SIAM J. Appl. Dyn. Syst. 15(1), 142; Williams, Kevrekidis & Rowley 2015, J. Nonlinear Sci. 25, 1307; Korda & Mezic
    2018, Automatica 93, 149.
    """
    training, lags = training_of(records, model, int(stride or 1)), int(output_lags or 1)
    system = lift(training, int(degree or 1), lags, alpha or 0.0, bilinear)
    return training.fit(system, lags)


class LiftedSystem(NamedTuple):
    """State g(q) of n entries, see `state_space.System`: q has d entries, inputs nu.

    Parameters
    ----------
    terms : (n, degree) of g, see `terms.evaluate`; the first d are q itself.
    bilinear : whether the products of inputs and state count as inputs.
    a, b, c : (n, n), (n, nu) or bilinear (n, nu (1 + n)), (n,).
    """

    terms: np.ndarray
    bilinear: bool
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray

    def begin(self, past: np.ndarray) -> np.ndarray:
        """States (N, n) after pasts (N, l (k + nu))."""
        from ..estimation.methods_only.black_box.terms import evaluate

        return evaluate(self.terms, past)

    def advance(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """States (N, n) one step on under inputs (N, nu)."""
        driving = with_products(inputs, state) if self.bilinear else inputs
        return state @ self.a.T + driving @ self.b.T + self.c


def with_products(inputs: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Inputs (N, nu), then their products with every entry of states (N, n): (N, nu (1 + n))."""
    return np.hstack([inputs, (inputs[:, :, None] * state[:, None, :]).reshape(len(state), -1)])


def lift(training: Training, degree: int, output_lags: int, alpha: float, bilinear: bool) -> LiftedSystem:
    """The system whose A, B and c have the penalty `alpha` of `terms.TermRegression`.

    Raises
    ------
    CannotFit : there are no more rows than unknowns of an equation, or no record is long enough for a row.
    """
    from ..estimation.methods_only.black_box.terms import TermRegression, evaluate, monomials

    terms = monomials(training.parts[0].outputs.shape[1] * output_lags, degree)[1:]
    past, inputs, ahead = _rows(training, output_lags)
    state = evaluate(terms, past)
    driving = with_products(inputs, state) if bilinear else inputs
    n, unknowns = len(terms), len(terms) + driving.shape[1] + 1
    if len(past) <= unknowns:
        raise CannotFit(f"{len(past)} usable rows for {unknowns} unknowns")
    regression = TermRegression(monomials(unknowns - 1, 1), alpha).fit(
        np.hstack([state, driving]), evaluate(terms, ahead)
    )
    found = np.zeros((unknowns, n))
    found[regression.terms_[:, 0]] = regression.weights_
    return LiftedSystem(terms, bilinear, found[1 : 1 + n].T.copy(), found[1 + n :].T.copy(), found[0])


def _rows(training: Training, output_lags: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pasts (N, l (k + nu)), inputs (N, nu) and pasts one step on, of all steps that are whole with their past."""
    s, found = training.stride, []
    for part in training.parts:
        place = whole_places(part.whole, s * (output_lags - 1), s)
        if place.size:
            past, ahead = (pasts(part, at, s, output_lags) for at in (place, place + s))
            found.append((past, part.inputs[place], ahead))
    if not found:
        raise CannotFit(f"no record is as long as {output_lags + 1} steps")
    past, inputs, ahead = (np.vstack(blocks) for blocks in zip(*found, strict=True))
    return past, inputs, ahead
