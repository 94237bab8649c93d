"""Free runs of whole records in tests."""

from dataclasses import replace

import numpy as np

from helmbench.diagnosis.free_runs.bank import of_numbers
from helmbench.diagnosis.free_runs.problem import FreeRuns
from helmbench.diagnosis.free_runs.units import whole_unit
from helmbench.estimation.selection.selection import mean_squares
from helmbench.models.time_scale import time_scale_s


def whole_runs(model, records):
    """Free runs of records that are units, each with a neutral rudder angle of its own."""
    length_s = time_scale_s(model)
    units = [replace(whole_unit(model, record, length_s), number=i) for i, record in enumerate(records)]
    return FreeRuns(of_numbers(model), units, length_s, whole=True)


def blind_errors(runs):
    """Root mean square errors (C,) of the model as it is, without own effects of the records."""
    return np.sqrt(mean_squares(runs, runs.squares([{}] * len(runs.units), runs.no_own)))
