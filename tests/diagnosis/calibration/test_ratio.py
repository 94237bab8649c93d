"""A number whose published one is the ratio to another: it has not changed where both moved in proportion."""

import numpy as np
import pytest

from helmbench.bench.kinds.base import Selection
from helmbench.bench.kinds.diagnosis.execute import base_of, injected_of
from helmbench.bench.kinds.diagnosis.plan import plan
from helmbench.bench.suites import load_suite
from helmbench.diagnosis.calibration.calibrate import calibrate

from ...injections import passes_often


@pytest.mark.parametrize(("base", "changed"), [("gain", "turning_gain"), ("lead", "lead")])
def test_a_wrong_gain_of_a_second_order_model_is_no_wrong_lead(rng, base, changed):
    """K stands in both numbers of the rudder, and T3 in one: b1 = K/(T1 T2), b2 = K T3/(T1 T2)."""

    def named_alone():
        seed = int(rng.integers(2**31))
        specs = plan(load_suite("one-bug"), Selection("one-bug", seed=seed))
        spec = next(s for s in specs if (s.vessel, s.base) == ("cargo", base))
        found = calibrate(base_of(spec), injected_of(spec).train)
        told = {m.group for m in found.moved if not m.may_have_stayed}
        print(seed, found.moved)
        assert np.isfinite([m.high - m.low for m in found.moved]).all()
        return told == {changed}

    assert passes_often(named_alone, rate=0.9, passes=1)
