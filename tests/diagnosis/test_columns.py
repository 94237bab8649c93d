"""Columns in another unit or with the other sign: findings of the diagnosis, and no error of held-out records."""

import numpy as np
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


def test_held_out_headings_are_scored_without_a_compass_deviation_that_no_instrument_shows(rng):
    case = inject(FaultCase("kvlcc2-l7", ()), rng)

    def deviated(record):
        true = record.heading_unwrapped()
        return record.with_channels(heading_rad=true + 0.06 * np.sin(true) + 0.03 * np.cos(true))

    right = diagnose(resolve("kvlcc2-l7"), case.train, case.held_out)
    found = diagnose(resolve("kvlcc2-l7"), [*map(deviated, case.train)], [*map(deviated, case.held_out)])
    assert [f.cause for f in found.causes] == ["compass_deviation"] and found.verdict == "named"
    assert found.gain["heading_rad"].own_after < 3.0 * right.gain["heading_rad"].own_after < np.deg2rad(0.5)
