"""What a selection starts from: records no finer than needed, the base model, the causes that can be tested."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..estimation.filters.innovations.settings import Parameter
from ..models.errors import CannotFit
from ..models.time_scale import ship_length_s
from .causes.registry import testable
from .report.bank import DECIDED
from .state import State, first_state

if TYPE_CHECKING:
    from ..checks.base import Check
    from ..datasets.record import Record
    from ..estimation.filters.innovations.estimator import Estimator
    from ..models.model import Model
    from .options import Options

FINEST = 0.03
"""Finest sampling of the records, in ship lengths sailed."""


def thinned(records: Sequence[Record], model: Model) -> list[Record]:
    """Records of a ship with a length and a speed, sampled no finer than FINEST: more samples would only cost time."""
    try:
        step_s = FINEST * ship_length_s(model)
    except CannotFit:
        return list(records)
    return [record.thinned(max(1, int(step_s / record.dt + 1e-9))) for record in records]


def starting_state(est: Estimator, options: Options, decided: Collection[Check] = ()) -> tuple[State, dict]:
    """The first state of the selection, and the causes that cannot be tested with the reason.

    decided : causes that the sensors' channels have decided on without the model.
    """
    bank, cannot = testable(est)
    only = options.causes()
    cannot |= {cause: DECIDED for cause in bank if cause in decided}
    if only is not None:
        cannot |= {cause: "left out" for cause in bank if cause not in only}
    bank = {cause: variants for cause, variants in bank.items() if cause not in cannot}
    nuisance, prior = _free_coefficients(est, options)
    speed = _reference_speed(est)
    prior = None if prior is None else np.append(prior, np.zeros(len(speed)))
    return first_state(est, bank, options.alpha, (*nuisance, *speed), prior), cannot


def _reference_speed(est: Estimator) -> tuple[Parameter, ...]:
    """The speed on a straight course against which a response model's surge shows a loss: estimated along."""
    if "speed_loss_state" not in est.kernels.STATES or not est.channels[2]:
        return ()
    return (Parameter("reference speed", "m/s", ((est.index["reference_speed"], 1.0),)),)


def _free_coefficients(est: Estimator, options: Options) -> tuple[tuple[Parameter, ...], np.ndarray | None]:
    """Coefficients that are estimated along, with the precisions of their prior."""
    model = est.model
    if options.base_parameters == "file" and not options.coefficient_sd:
        return (), None
    pairs = zip(model.coordinates, model.coefficients.tolist(), strict=True)
    found = tuple(Parameter(name, "", ((est.index[name], abs(value)),)) for name, value in pairs if value != 0.0)
    if options.base_parameters == "identify":
        return found, None
    return found, np.full(len(found), (options.coefficient_sd or 1.0) ** -2.0)
