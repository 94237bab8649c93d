"""Diagnoses of fixed seeds give the stored outcomes: verdict, causes, ties, sizes.

A change that moves them is looked at and explained; then `python -m tests.diagnosis.test_golden` stores the new ones.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

from ..injections import injected
from .documents import faults

STORED = Path(__file__).with_name("golden.json")
CASES = {
    "clean": ("mariner", (), "large", "slow"),
    "rudder-offset": ("mariner", ("rudder_offset",), "moderate", "none"),
    "backlash": ("s175", ("rudder_backlash",), "large", "fast"),
    "gyro-scale": ("kvlcc2-l7", ("yaw_rate_scale",), "moderate", "none"),
    "rudder-delay": ("response-1", ("rudder_delay",), "large", "none"),
    "two": ("mariner", ("rudder_effectiveness", "current"), "large", "none"),
    "outside-the-bank": ("cargo", ("pulse",), "large", "none"),
}
"""Name -> ship, effects, strength, gusts."""


def outcome(name: str) -> dict:
    """What is stored of a diagnosis."""
    vessel, causes, strength, gusts = CASES[name]
    rng = np.random.default_rng(int.from_bytes(name.encode(), "little") % 2**32)
    case = injected(vessel, causes, rng, strength, gusts)
    found = diagnose(resolve(vessel), case.train, case.held_out[:1], Options(coefficient_sd=0.0))
    assert faults(found.to_json()) == []
    return {
        "truth": [effect["cause"] for effect in case.truth],
        "verdict": found.verdict,
        "causes": [
            {
                "cause": f.cause,
                "tied_with": sorted(f.tied_with),
                "sizes": [[s.parameter, s.value, s.low, s.high] for s in f.sizes],
            }
            for f in found.causes
        ],
        "heading_rmse_deg": [
            np.rad2deg(found.gain["heading_rad"].rmse_before),
            np.rad2deg(found.gain["heading_rad"].rmse_after),
        ],
    }


@pytest.mark.parametrize("name", CASES)
def test_outcome_is_the_stored_one(name):
    found, stored = outcome(name), json.loads(STORED.read_text(encoding="utf-8"))
    expected = stored[name]
    assert [found["truth"], found["verdict"]] == [expected["truth"], expected["verdict"]]
    for ours, theirs in zip(found["causes"], expected["causes"], strict=True):
        assert [ours["cause"], ours["tied_with"]] == [theirs["cause"], theirs["tied_with"]]
        for (parameter, *numbers), (known, *others) in zip(ours["sizes"], theirs["sizes"], strict=True):
            assert parameter == known
            assert numbers == pytest.approx(others, abs=0.02 * (others[2] - others[1]))
    assert found["heading_rmse_deg"] == pytest.approx(expected["heading_rmse_deg"], rel=0.02)


if __name__ == "__main__":
    STORED.write_text(json.dumps({name: outcome(name) for name in CASES}, indent=1) + "\n", encoding="utf-8")
