"""How often two wrong numbers of an imperfect base are named, and no other."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve

from ...expectations.injections import Expectation

MANOEUVRES = ("zigzag:10/10", "zigzag:20/20:port", "turn:30", "zigzag:25/5", "turn:15:port")


def two_wrong_numbers_are_named_and_no_other(rng: np.random.Generator) -> bool:
    """Neither is the one that alone explains most: step by step another number would go first."""
    base = resolve("mariner")
    names = (*base.coordinates, *base.constant_names)
    wrong = base.theta.copy()
    wrong[names.index("Nd")] *= 1.15
    wrong[names.index("m33")] *= 1.3
    count = len(base.coordinates)
    base = replace(base, coefficients=wrong[:count], constants=wrong[count:])
    made = inject(FaultCase("mariner", train=MANOEUVRES, held_out=("zigzag:15/15",), duration_s=400.0, dt_s=1.0), rng)
    found = diagnose(base, made.train, made.held_out)
    true = dict(zip(names, resolve("mariner").theta.tolist(), strict=True))
    sizes = {size.parameter: size.value for f in found.causes for size in f.sizes}
    print(found.verdict, [f.cause for f in found.causes], sizes)
    assert found.calibrated is not None and set(found.calibrated_gain) >= {"yaw_rate_rad_s", "heading_rad"}
    return (
        found.verdict == "named"
        and [f.cause for f in found.causes] == ["base_coefficients"]
        and sizes == pytest.approx({"Nd": true["Nd"], "m33": true["m33"]}, rel=0.05)
        and found.gain["yaw_rate_rad_s"].rmse_after < 0.6 * found.gain["yaw_rate_rad_s"].rmse_before
    )


TWO_NUMBERS = Expectation(two_wrong_numbers_are_named_and_no_other, 0.8)
"""In the other draws one number is named that explains both, or a rudder offset beside them."""
