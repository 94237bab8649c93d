"""An inverse physics-informed neural network."""

from __future__ import annotations

from collections.abc import Sequence

from ..datasets.record import Record
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import method
from .options import POSITIVE, number, option, whole


@method(
    "pinn",
    "inverse physics-informed neural network: states as networks of time, held to the model's equations",
    minutes=True,
    brief={"spacing": 8.0, "iterations": 4},
)
def Pinn(
    records: Sequence[Record],
    model: Model,
    weight: float = option(
        1e4,
        "of the equations: 1e4 takes an error of 1 % of a state's rate as seriously as one standard deviation of a "
        "sensor",
        POSITIVE,
    ),
    spacing: float = option(
        1.5, "samples for each hidden unit", number("a number of at least 1", lambda value: value >= 1.0)
    ),
    iterations: int = option(40, "at most", whole(1)),
) -> Fit:
    """Networks of time that follow the records and the model's equations, the coefficients found with their weights.

        min sum ((x(t_k) - y_k)/sd)^2 + weight sum ((dx/dt - f(x, u, theta))(t_j)/q)^2

    Raissi, Perdikaris & Karniadakis 2019, J. Comput. Phys. 378, 686 (inverse problem).  The networks are local, one for
    each 200 steps of a record; their hidden layer of tanh units is spread evenly over time and not trained, the
    integrals of the inputs are features beside it, and the minimum is found by Levenberg-Marquardt steps
    (`helmbench.estimation.methods_only.physics_informed`).

    Standard errors are those with the networks free, for white errors of the sensors and of the equations.  No
    network knows where the one before it ended, so records whose 200 steps are shorter than the ship's time constants
    give less than they do to a free run (`output-error`).
    """
    from ..estimation.methods_only.physics_informed.fit import identify

    return identify(records, model, weight, spacing, iterations)
