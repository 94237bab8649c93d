"""Base models with one mistake, the right ship's records by the truth simulator: its group alone has changed."""

import numpy as np
import pytest

from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.bases import bug_of
from helmbench.bench.kinds.diagnosis.execute import base_of, injected_of
from helmbench.bench.kinds.diagnosis.plan import plan
from helmbench.bench.suites import load_suite
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.models.coefficient_groups import groups_of

from ...expectations.injections import passes
from ...nightly_marks import nightly_but

CASES = [
    ("cargo", "gain", "turning_gain"),  # K stands in both numbers of the rudder: b1 = K/(T1 T2), b2 = K T3/(T1 T2)
    ("cargo", "lead", "lead"),
    ("mariner", "stall", "rudder_large_angle"),  # coefficients that a published table lacks
]


@pytest.mark.parametrize("case", nightly_but(CASES), ids=str)
def test_the_group_of_a_mistake_alone_has_changed(rng, case):
    ship, bug, changed = case

    def named_alone():
        seed = int(rng.integers(2**31))
        specs = plan(load_suite("one-bug"), RunSelection("one-bug", seed=seed))
        spec = next(s for s in specs if (s.vessel, s.base) == (ship, bug))
        found = calibrate(base_of(spec), injected_of(spec).train)
        told = {m.group for m in found.moved if not (m.in_proportion or m.low <= m.before <= m.high)}
        print(seed, found.moved)
        assert np.isfinite([m.high - m.low for m in found.moved]).all()
        return told == {changed}

    assert passes(named_alone, 0.9)


def test_what_a_table_lacks_may_be_of_the_size_of_the_number_it_is_like():
    model = bug_of("mariner", "stall").base()
    linear = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    group = next(g for g in groups_of(model) if g.id == "rudder_large_angle")
    assert group.sd == pytest.approx({"Yddd": 0.5 * abs(linear["Yd"]), "Nddd": 0.5 * abs(linear["Nd"])})
