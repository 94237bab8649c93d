"""Columns in another unit or with the other sign: findings of the diagnosis, and no error of held-out records."""

import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve
from helmbench.reporting.diagnosis import words

KNOT = 1852.0 / 3600.0


@pytest.mark.parametrize(
    ("column", "factor", "cause", "said"),
    [
        pytest.param("sway_m_s", -1.0, "channel_sign", "channel sign of sway", marks=pytest.mark.nightly),
        ("surge_m_s", 1.0 / KNOT, "wrong_unit", "wrong unit of"),
    ],
)
def test_a_column_that_was_corrected_as_a_whole_is_named_first(column, factor, cause, said, rng):
    case = inject(FaultCase("kvlcc2-l7", ()), rng)
    train, held_out = (
        [r.with_channels(**{column: factor * r.column(column)}) for r in side] for side in (case.train, case.held_out)
    )
    found = diagnose(resolve("kvlcc2-l7"), train, held_out)
    assert found.verdict == "named" and [f.cause for f in found.causes] == [cause]
    assert column in found.causes[0].details["columns"]
    assert words.headline(found).startswith(f"Named: {said}")
    right = diagnose(resolve("kvlcc2-l7"), case.train, case.held_out)
    assert right.verdict == "adequate"
    for channel, gain in right.gain.items():
        assert found.gain[channel].rmse_after == pytest.approx(gain.rmse_after, rel=0.02), channel
