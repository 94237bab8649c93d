"""The diagnosis of a base model that is stated to be exact."""

import numpy as np

from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.innovations.diagnose import PREDICTS_WORSE
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

from ...expectations.injections import injected


def test_a_cause_that_worsens_held_out_records_is_withdrawn(rng):
    """The rudder is 2 deg off in the training records, and to the other side in the held-out one."""
    case = injected("response-1", (), rng, train=("zigzag:20/20", "zigzag:10/10"), held_out=("zigzag:20/20",))
    sides = [
        [r.with_channels(rudder_rad=r.column("rudder_rad") + side) for r in records]
        for records, side in ((case.train, np.deg2rad(2.0)), (case.held_out, -np.deg2rad(2.0)))
    ]
    alike = sides[0][1:]
    model, exact = resolve("response-1"), Options(coefficient_sd=0.0)
    named, withdrawn = (diagnose(model, sides[0][:1], held, exact) for held in (alike, sides[1]))
    assert [f.cause for f in named.causes] == ["rudder_offset"] and PREDICTS_WORSE not in named.reason
    assert named.extended.family == f"{model.family}+rudder_offset"
    assert withdrawn.verdict == "unexplained" and PREDICTS_WORSE in withdrawn.reason
    assert withdrawn.extended.instruments == model.instruments
