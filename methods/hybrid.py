"""A physical model with learnt residual accelerations: polynomials, or Gaussian processes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..estimation.methods_only.black_box.hybrid import HybridPredictor, innovation_rows
from ..estimation.methods_only.black_box.rows import Lags, signals_of
from ..estimation.methods_only.black_box.scaled import evenly_spaced, fit_scaled
from ..estimation.methods_only.tuning.space import Choice, Integer, Real
from ..estimation.methods_only.tuning.tune import validation_of
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from ..models.model import Model
from .base import method
from .learner import Learner, open_option
from .options import option
from .registry import make


def _check_physics(name: str, value: Any) -> None:
    if isinstance(value, str) and make(value).kind != "grey box":
        raise BadInput(f"{name} is {value!r}, a method that estimates coefficients is needed")


class Hybrid(Learner):
    """Base of physical models with learnt residual accelerations; the function gives a new regressor of these.

    The physics is identified once on the records, and once on the stretches of them that the search of options fits.
    """

    kind = "hybrid"
    rows: ClassVar[int | None] = None
    """Most training rows, evenly spaced."""
    physics: str | Estimate = option(
        "output-error", "method that identifies the coefficients, such as 'output-error' or 'pem'", _check_physics
    )
    share: float | None = open_option("of g", Choice(0.0, 0.5, 1.0), 0.0)
    stride: int | None = None

    def for_search(self, records: Sequence[Record], model: Model) -> Learner:
        """The method with the physics as identified on what a trial fits."""
        return self._with({"physics": self._identified(validation_of(records, "split").train, model)})

    def _identified(self, records: Sequence[Record], model: Model) -> Estimate:
        return make(self.physics).fit(records, model) if isinstance(self.physics, str) else self.physics

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        found = self._identified(records, model)
        x, y = innovation_rows(signals_of(records, model), found.model, int(self.stride or 1))
        chosen = evenly_spaced(len(x), self.rows)
        learnt = fit_scaled(x[chosen], y[chosen], self.computed, Lags().features(model))
        return Fit(
            found.coefficients,
            found.covariance,
            converged=found.converged,
            message=found.message,
            n_iterations=found.n_iterations,
            extra={"rows": len(chosen)},
            predictor=HybridPredictor(found.model, learnt, float(self.share or 0.0)),
        )


@method(
    "grey-residual",
    "physical model with polynomial residual accelerations, learnt from its innovations",
    Hybrid,
    usual_trials=8,
    stride=open_option("step of the innovations in samples", Integer(1, 16, log=True), 4),
)
def GreyResidual(
    n_features: int, alpha: float | None = open_option("ridge penalty", Real(1e-6, 1.0, log=True), 1e-2)
) -> Any:
    """A physical model, identified, plus polynomial residual accelerations learnt from its innovations.

        z(t + h) = Phi(z(t), w(t)) + share h g(z(t), w(t))

    Phi is the motion of the model with coefficients identified by `physics`; g is a polynomial of degree two of
    velocities, yaw rate and inputs, by ridge regression on the one-step errors (z(t + h) - Phi) / h.  `share` may be
    zero: then the records ask for nothing but the physics.  The coefficients are those of the physics alone.  Sources:
    Forssell & Lindskog 1997, IFAC SYSID, 481 (semi-physical and neural modelling combined); Psichogios & Ungar 1992,
    AIChE J. 38(10), 1499.
    """
    from ..estimation.methods_only.black_box.terms import TermRegression, monomials

    return TermRegression(monomials(n_features, 2), alpha=alpha or 0.0)


@method(
    "grey-gp",
    "physical model with a Gaussian process of residual accelerations",
    Hybrid,
    rows=300,
    usual_trials=4,
    stride=open_option("step of the innovations in samples", Integer(2, 16, log=True), 4),
)
def GreyGp(n_features: int) -> Any:
    """A physical model, identified, plus a Gaussian process of its residual accelerations.

    As `grey-residual`, with g the mean of a Gaussian process with a squared-exponential kernel and white noise, on at
    most 300 rows.  Far from the training records g is zero, and the physics remains.  Source: Kennedy & O'Hagan 2001,
    J. R. Stat. Soc. B 63(3), 425 (the discrepancy of a calibrated model as a Gaussian process).
    """
    from ..estimation.methods_only.black_box.limited import gaussian_process

    return gaussian_process(n_features)
