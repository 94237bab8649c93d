"""An inverse physics-informed neural network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Pinn(Method):
    """Networks of time that follow the records and the model's equations, the coefficients found with their weights.

        min sum ((x(t_k) - y_k)/sd)^2 + weight sum ((dx/dt - f(x, u, theta))(t_j)/q)^2

    Raissi, Perdikaris & Karniadakis 2019, J. Comput. Phys. 378, 686 (inverse problem).  The networks are local, one for
    each 200 steps of a record; their hidden layer of tanh units is spread evenly over time and not trained, the
    integrals of the inputs are features beside it, and the minimum is found by Levenberg-Marquardt steps
    (`helmbench.estimation.methods_only.physics_informed`).  f and its derivatives are jax's, so the method needs the
    extra `deep`.

    Parameters
    ----------
    weight : > 0, of the equations: 1e4 takes an error of 1 % of a state's rate as seriously as one standard
        deviation of a sensor.
    spacing : >= 1, samples for each hidden unit.
    iterations : at most.

    Standard errors are those with the networks free, for white errors of the sensors and of the equations.  No
    network knows where the one before it ended, so records whose 200 steps are shorter than the ship's time constants
    give less than they do to a free run (`output-error`).
    """

    name = "pinn"
    title = "inverse physics-informed neural network: states as networks of time, held to the model's equations"
    minutes = True
    brief: ClassVar = {"spacing": 8.0, "iterations": 4}

    def __init__(self, weight: float = 1e4, spacing: float = 1.5, iterations: int = 40) -> None:
        self.weight, self.spacing, self.iterations = weight, spacing, iterations

    def check_options(self) -> None:
        super().check_options()
        self.require_whole("iterations", 1)
        if not self.weight > 0.0:
            raise BadInput(f"weight is {self.weight!r}, a positive number is needed")
        if not self.spacing >= 1.0:
            raise BadInput(f"spacing is {self.spacing!r}, a number of at least 1 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.physics_informed.fit import identify

        return identify(records, model, self.weight, self.spacing, self.iterations)
