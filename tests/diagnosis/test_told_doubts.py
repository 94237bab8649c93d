"""What a diagnosis says of doubts and of steps that fail."""

import pytest

import helmbench
from helmbench.bench.faults import FaultCase, inject
from helmbench.diagnosis import diagnose as engine
from helmbench.models.model import resolve


@pytest.mark.parametrize("reversed_sway", [True, False])
def test_a_doubt_about_a_column_that_was_corrected_is_not_told(reversed_sway, rng):
    """The sway of a ship that turns about its stern is doubtful as it stands, and is right where it was turned."""
    records = inject(FaultCase("mariner", (), wrap=False), rng).train
    wrong = [r.with_channels(sway_m_s=-r.column("sway_m_s")) for r in records]
    bare = [r.with_channels(north_m=None, east_m=None) for r in wrong]  # nothing corrects it then
    found = helmbench.diagnose("mariner", wrong if reversed_sway else bare, causes=["channel_swap"])
    print(found.doubts, [f.evidence for f in found.checks])
    assert any("sway" in f.evidence for f in found.checks if f.corrected) is reversed_sway
    assert any("sway_m_s: turns about a point" in doubt for doubt in found.doubts) is not reversed_sway


def test_a_step_whose_arithmetic_fails_is_told(monkeypatch, rng):
    def fail(*args):
        raise ValueError("an array of the wrong shape")

    monkeypatch.setattr(engine, "with_remaining", fail)
    found = engine.diagnose(resolve("response-1"), inject(FaultCase("response-1", ()), rng).train)
    assert any("not described" in doubt and "wrong shape" in doubt for doubt in found.doubts)
