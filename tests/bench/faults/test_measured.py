"""Effects in measured records: what the simulated sensor would have given."""

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject, inject_in_record
from helmbench.models.errors import BadInput

QUIET = {"noise": 0.0, "wrap": False, "duration_s": 200.0, "train": ("zigzag:20/20",), "held_out": ("turn:10",)}


def pair(effect: Effect, rng: np.random.Generator):
    """A noise-free record without and with an effect that leaves the motion as it is."""
    seed = int(rng.integers(2**32))
    cases = FaultCase("mariner", **QUIET), FaultCase("mariner", effects=(effect,), **QUIET)
    return [inject(case, np.random.default_rng(seed)).train[0] for case in cases]


def test_changed_records_read_as_simulated_ones(rng: np.random.Generator) -> None:
    """A sensor cause in a finished record is what the simulated sensor gives."""
    for cause, parameters in {
        "yaw_rate_scale": {"s": 0.1},
        "sway_offset": {"b": 0.2},
        "axis_misalignment": {"angle": 0.05},
        "earth_frame_velocity": {},
        "heading_delay": {"tau": 1.0},
    }.items():
        clean, expected = pair(Effect(cause, parameters), rng)
        found = inject_in_record(clean, cause, parameters, rng)
        for channel in found.channels:
            known = np.isfinite(found.column(channel))
            assert known.mean() > 0.9
            assert found.column(channel)[known] == pytest.approx(expected.column(channel)[known], abs=1e-6), (
                cause,
                channel,
            )


def test_a_changed_rudder_column_gives_the_true_one_at_the_hull(rng: np.random.Generator) -> None:
    """hull = (1 + e) recorded(t - tau) + delta0 gives the unchanged rudder again."""
    clean, _ = pair(Effect("yaw_rate_bias", {"b": 0.0}), rng)
    rudder = clean.rudder()
    offset = inject_in_record(clean, "rudder_offset", {"delta0": 0.02}, rng).rudder() + 0.02
    weak = 0.8 * inject_in_record(clean, "rudder_effectiveness", {"e": -0.2}, rng).rudder()
    moved = inject_in_record(clean, "rudder_delay", {"tau": 1.0}, rng).rudder()
    late = np.interp(clean.time_s - 1.0, clean.time_s, moved)
    assert offset == pytest.approx(rudder)
    assert weak == pytest.approx(rudder)
    assert late[5:] == pytest.approx(rudder[5:], abs=1e-9)
    with pytest.raises(BadInput, match="wind cannot be injected in a measured record"):
        inject_in_record(clean, "wind", {}, rng)
    with pytest.raises(BadInput, match="needs the column"):
        inject_in_record(clean.with_channels(surge_m_s=None), "speed_scale", {"s": 0.1}, rng)
