"""Cases: what is planted is what the truth says, as strong as asked."""

import numpy as np
import pytest

from helmbench.bench.faults import (
    ANTICIPATED,
    CAUSES,
    SPOILERS,
    UNFORESEEN,
    VESSELS,
    Case,
    Effect,
    carries,
    plant,
    spoil,
)
from helmbench.bench.faults.case import Frames, noncentrality
from helmbench.bench.faults.effects import CATALOGUE
from helmbench.bench.faults.sensing import noise_sd
from helmbench.bench.faults.ships import ship
from helmbench.models.errors import BadInput

QUIET = {
    "noise": 0.0,
    "wrap": False,
    "duration_s": 200.0,
    "train": ("zigzag:20/20", "turn:20"),
    "held_out": ("turn:10",),
}

TAXONOMY = """
rudder_offset rudder_effectiveness rudder_delay rudder_fault rudder_backlash rudder_rate_limit rudder_saturation
rudder_sign yaw_rate_bias yaw_rate_scale heading_offset speed_scale sway_offset heading_delay velocity_delay
earth_frame_velocity channel_swap axis_misalignment outliers clock_jitter current wind wave_motion wave_drift
constant_force yaw_damping_quadratic yaw_damping_cubic sway_damping_quadratic crossflow_coupling speed_loss
second_order_lead loading_change shallow_water coefficient_shift
"""


def brief(vessel: str) -> dict:
    """Two training records and one held-out record of a few ship lengths' time."""
    clock = 1.0 if ship(vessel).clock > 0.5 else 0.25
    texts = "zigzag:20/20", f"steps:20deg/{30 * clock:g}s", "zigzag:10/10"
    return {"duration_s": 200.0 * clock, "train": texts[:2], "held_out": texts[2:]}


def pair(effect: Effect, rng: np.random.Generator, vessel: str = "mariner", record: int = 0):
    """A noise-free record without and with an effect that leaves the motion as it is."""
    seed = int(rng.integers(2**32))
    cases = Case(vessel, **QUIET), Case(vessel, effects=(effect,), **QUIET)
    return [plant(case, np.random.default_rng(seed)).train[record] for case in cases]


@pytest.mark.parametrize("vessel", VESSELS)
def test_a_case_has_its_strength(vessel: str, rng: np.random.Generator) -> None:
    names = [name for name in CATALOGUE if carries(ship(vessel), name) and CATALOGUE[name].sized]
    for cause in rng.choice(names, 2, replace=False):
        planted = plant(Case(vessel, (str(cause),), 300.0, **brief(vessel)), rng)
        assert [effect["cause"] for effect in planted.truth] == [cause]
        capped = CATALOGUE[cause].inverse or CATALOGUE[cause].cap < np.inf
        assert capped or 150.0 < planted.noncentrality < 600.0, cause
        records = [*planted.train, *planted.held_out]
        assert (len(planted.train), len(planted.held_out)) == (2, 1)
        assert all(np.isfinite(values).all() for r in records for values in r.channels.values())


def test_no_planted_ship_runs_away(rng: np.random.Generator) -> None:
    """A damping that feeds a cargo ship's turn is made weaker until she can be steered."""
    for _ in range(6):
        planted = plant(Case("cargo", ("yaw_damping_quadratic",), "large"), rng)
        rates = [np.abs(r.column("yaw_rate_rad_s")).max() for r in (*planted.train, *planted.held_out)]
        print(planted.truth, planted.noncentrality, rates)
        assert max(rates) < 0.2 and planted.noncentrality > 20.0


@pytest.mark.parametrize("vessel", VESSELS)
def test_nothing_planted_has_no_strength(vessel: str, rng: np.random.Generator) -> None:
    case = Case(vessel, **brief(vessel)).settled()
    assert noncentrality(case, (), Frames.draw(case, rng), None) < 1e-3


def test_equal_seeds_give_equal_records(seed: int) -> None:
    case = Case("mariner", ("current", "yaw_rate_bias"), "faint", gusts="fast", gaps=0.2, **brief("mariner"))
    one, two = (plant(case, np.random.default_rng(seed)) for _ in range(2))
    assert all(a.equals(b) for a, b in zip(one.train + one.held_out, two.train + two.held_out, strict=True))
    assert one.truth == two.truth
    assert any(np.isnan(values).any() for values in one.train[0].channels.values())


def test_noise_is_the_sensors(rng: np.random.Generator) -> None:
    for vessel in ("mariner", "kvlcc2-l7"):
        record = plant(Case(vessel, wrap=False, train=("straight",)), rng).train[0]
        for channel, sd in noise_sd(ship(vessel)).items():
            third = np.diff(record.column(channel), 3).std() / np.sqrt(20.0)
            assert third == pytest.approx(sd, rel=0.2), channel


def test_sensor_causes_are_what_they_say(rng: np.random.Generator) -> None:
    clean, biased = pair(Effect("yaw_rate_bias", {"b": 1e-3}), rng)
    assert biased.column("yaw_rate_rad_s") - clean.column("yaw_rate_rad_s") == pytest.approx(1e-3)
    clean, late = pair(Effect("heading_delay", {"tau": 1.5}), rng)
    assert late.column("heading_rad")[3:] == pytest.approx(clean.column("heading_rad")[:-3], abs=1e-9)
    clean, framed = pair(Effect("earth_frame_velocity", {}), rng, record=1)
    north = np.gradient(clean.column("north_m"), 0.5)
    assert np.abs(framed.column("surge_m_s") - north)[2:-2].max() < 0.02
    clean, turned = pair(Effect("axis_misalignment", {"angle": 0.1}), rng)
    assert turned.column("sway_m_s")[0] == pytest.approx(-np.sin(0.1) * 7.7175)
    clean, swapped = pair(Effect("channel_swap", {"channels": ("north_m", "east_m")}), rng)
    assert swapped.column("north_m") == pytest.approx(clean.column("east_m"))


def test_forces_differ_by_record(rng: np.random.Generator) -> None:
    speeds, ways = (0.5, 0.0, 0.25), (0.0, 0.0, np.pi / 2)
    case = Case("mariner", effects=(Effect("current", {"speed": speeds, "towards": ways}),), **QUIET)
    planted = plant(case, rng)
    for record, speed, way in zip([*planted.train, *planted.held_out], speeds, ways, strict=True):
        u, v, psi = (record.column(c)[0] for c in ("surge_m_s", "sway_m_s", "heading_rad"))
        over_ground = np.array([u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)])
        water = over_ground - speed * np.array([np.cos(way), np.sin(way)])
        assert np.hypot(*water) == pytest.approx(7.7175)


def test_command_records_hold_the_command(rng: np.random.Generator) -> None:
    planted = plant(Case("mariner", ("rudder_rate_limit",), "gross", **brief("mariner")), rng)
    assert planted.train[0].has("rudder_command_rad") and not planted.train[0].has("rudder_rad")


def test_every_kind_moves_the_ship(rng: np.random.Generator) -> None:
    for kind in [*ANTICIPATED, *UNFORESEEN]:
        planted = plant(Case("mariner", (kind,), "large", **brief("mariner")), rng)
        assert planted.noncentrality > 50.0, kind
        assert not np.isnan(planted.held_out[0].column("heading_rad")).any(), kind


def test_what_a_ship_cannot_carry_is_refused() -> None:
    assert not carries(ship("response-1"), "current")
    assert not carries(ship("mariner"), "second_order_lead")
    with pytest.raises(BadInput, match="response-1 cannot carry wind"):
        Case("response-1", ("wind",))
    with pytest.raises(BadInput, match="nothing called"):
        Case("mariner", ("gremlins",))
    with pytest.raises(BadInput, match="strength"):
        Case("mariner", ("wind",), "huge")


def test_spoiled_records_read_as_planted_ones(rng: np.random.Generator) -> None:
    """A sensor cause in a finished record is what the simulated sensor gives."""
    for cause, parameters in {
        "yaw_rate_scale": {"s": 0.1},
        "sway_offset": {"b": 0.2},
        "axis_misalignment": {"angle": 0.05},
        "earth_frame_velocity": {},
        "heading_delay": {"tau": 1.0},
    }.items():
        clean, expected = pair(Effect(cause, parameters), rng)
        found = spoil(clean, cause, parameters, rng)
        for channel in found.channels:
            known = np.isfinite(found.column(channel))
            assert known.mean() > 0.9
            assert found.column(channel)[known] == pytest.approx(expected.column(channel)[known], abs=1e-6), (
                cause,
                channel,
            )


def test_spoiled_rudder_makes_the_hull_late_and_off(rng: np.random.Generator) -> None:
    """hull = (1 + e) recorded(t - tau) + delta0 gives the unspoiled rudder again."""
    clean, _ = pair(Effect("yaw_rate_bias", {"b": 0.0}), rng)
    rudder = clean.rudder()
    offset = spoil(clean, "rudder_offset", {"delta0": 0.02}, rng).rudder() + 0.02
    weak = 0.8 * spoil(clean, "rudder_effectiveness", {"e": -0.2}, rng).rudder()
    late = np.interp(clean.time_s - 1.0, clean.time_s, spoil(clean, "rudder_delay", {"tau": 1.0}, rng).rudder())
    assert offset == pytest.approx(rudder)
    assert weak == pytest.approx(rudder)
    assert late[5:] == pytest.approx(rudder[5:], abs=1e-9)
    with pytest.raises(BadInput, match="wind cannot be planted in a measured record"):
        spoil(clean, "wind", {}, rng)
    with pytest.raises(BadInput, match="needs the column"):
        spoil(clean.with_channels(surge_m_s=None), "speed_scale", {"s": 0.1}, rng)


def test_the_catalogue_is_the_taxonomy() -> None:
    assert set(CAUSES) == set(TAXONOMY.split())
    assert len(UNFORESEEN) >= 8
    assert set(SPOILERS) < set(CAUSES)
