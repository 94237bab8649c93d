"""Cases: what is injected is what the truth says, as strong as asked."""

import numpy as np
import pytest

from helmbench.bench.faults import (
    ANTICIPATED,
    UNFORESEEN,
    VESSELS,
    Effect,
    FaultCase,
    inject,
    kind_of,
    kinds,
    names_of,
    noncentrality,
)  # fmt: skip
from helmbench.bench.faults.frames import Frames
from helmbench.bench.faults.injected import own_numbers
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


def brief(vessel: str) -> dict:
    """Two training records and one held-out record of a few ship lengths' time."""
    clock = 1.0 if ship(vessel).clock > 0.5 else 0.25
    texts = "zigzag:20/20", f"steps:20deg/{30 * clock:g}s", "zigzag:10/10"
    return {"duration_s": 200.0 * clock, "train": texts[:2], "held_out": texts[2:]}


def pair(effect: Effect, rng: np.random.Generator, vessel: str = "mariner", record: int = 0):
    """A noise-free record without and with an effect that leaves the motion as it is."""
    seed = int(rng.integers(2**32))
    cases = FaultCase(vessel, **QUIET), FaultCase(vessel, effects=(effect,), **QUIET)
    return [inject(case, np.random.default_rng(seed)).train[record] for case in cases]


@pytest.mark.parametrize("vessel", VESSELS)
def test_a_case_has_its_strength(vessel: str, rng: np.random.Generator) -> None:
    names = [name for name, kind in kinds().items() if kind.carried_by(ship(vessel)) and kind.sized]
    for cause in rng.choice(names, 2, replace=False):
        injected = inject(FaultCase(vessel, (str(cause),), 300.0, **brief(vessel)), rng)
        assert [effect["cause"] for effect in injected.truth] == [cause]
        capped = kind_of(cause).inverse or kind_of(cause).cap < np.inf
        assert capped or 150.0 < injected.noncentrality < 600.0, cause
        records = [*injected.train, *injected.held_out]
        assert (len(injected.train), len(injected.held_out)) == (2, 1)
        assert all(np.isfinite(values).all() for r in records for values in r.channels.values())


def test_no_injected_damping_makes_a_ship_unstable(rng: np.random.Generator) -> None:
    """A damping that feeds a cargo ship's turn is made weaker until she can be steered."""
    for _ in range(6):
        injected = inject(FaultCase("cargo", ("yaw_damping_quadratic",), "large"), rng)
        rates = [np.abs(r.column("yaw_rate_rad_s")).max() for r in (*injected.train, *injected.held_out)]
        print(injected.truth, injected.noncentrality, rates)
        assert max(rates) < 0.2 and injected.noncentrality > 20.0


@pytest.mark.parametrize("vessel", VESSELS)
def test_no_effect_has_no_strength(vessel: str, rng: np.random.Generator) -> None:
    frames = Frames.draw(FaultCase(vessel, **brief(vessel)), rng)
    assert noncentrality(frames, ()) < 1e-3


def test_what_the_ships_own_numbers_can_do_is_no_strength(rng: np.random.Generator) -> None:
    """Beside numbers of 5 % a rudder of a response model that is 2 % stronger is a turning gain: at most (2/5)^2."""
    frames = Frames.draw(FaultCase("response-1", beside=0.05, **brief("response-1")), rng)
    own = own_numbers(frames)
    stronger, late = (Effect("rudder_effectiveness", {"e": 0.02}),), (Effect("rudder_delay", {"tau": 2.0}),)
    (gain, gain_left), (delay, delay_left) = (
        [noncentrality(frames, effects, numbers) for numbers in (None, own)] for effects in (stronger, late)
    )
    print(gain, gain_left, delay, delay_left)
    assert gain > 10.0 and gain_left < 0.17
    assert 1.0 < delay_left < delay


def test_equal_seeds_give_equal_records(seed: int) -> None:
    case = FaultCase("mariner", ("current", "yaw_rate_bias"), "faint", gusts="fast", gaps=0.2, **brief("mariner"))
    one, two = (inject(case, np.random.default_rng(seed)) for _ in range(2))
    assert all(a.equals(b) for a, b in zip(one.train + one.held_out, two.train + two.held_out, strict=True))
    assert one.truth == two.truth
    assert any(np.isnan(values).any() for values in one.train[0].channels.values())


def test_noise_is_the_sensors(rng: np.random.Generator) -> None:
    for vessel in ("mariner", "kvlcc2-l7"):
        record = inject(FaultCase(vessel, wrap=False, train=("straight",)), rng).train[0]
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
    case = FaultCase("mariner", effects=(Effect("current", {"speed": speeds, "towards": ways}),), **QUIET)
    injected = inject(case, rng)
    for record, speed, way in zip([*injected.train, *injected.held_out], speeds, ways, strict=True):
        u, v, psi = (record.column(c)[0] for c in ("surge_m_s", "sway_m_s", "heading_rad"))
        over_ground = np.array([u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)])
        water = over_ground - speed * np.array([np.cos(way), np.sin(way)])
        assert np.hypot(*water) == pytest.approx(7.7175)


def test_command_records_hold_the_command(rng: np.random.Generator) -> None:
    injected = inject(FaultCase("mariner", ("rudder_rate_limit",), "gross", **brief("mariner")), rng)
    assert injected.train[0].has("rudder_command_rad") and not injected.train[0].has("rudder_rad")


def test_every_kind_moves_the_ship(rng: np.random.Generator) -> None:
    for kind in [*names_of(ANTICIPATED), *names_of(UNFORESEEN)]:
        injected = inject(FaultCase("mariner", (kind,), "large", **brief("mariner")), rng)
        assert injected.noncentrality > 50.0, kind
        assert not np.isnan(injected.held_out[0].column("heading_rad")).any(), kind


def test_what_a_ship_cannot_carry_is_refused() -> None:
    assert not kind_of("current").carried_by(ship("response-1"))
    assert not kind_of("second_order_lead").carried_by(ship("mariner"))
    with pytest.raises(BadInput, match="response-1 cannot carry wind"):
        FaultCase("response-1", ("wind",))
    with pytest.raises(BadInput, match="unknown effect 'gremlins'"):
        FaultCase("mariner", ("gremlins",))
    with pytest.raises(BadInput, match="strength"):
        FaultCase("mariner", ("wind",), "huge")
