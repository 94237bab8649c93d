"""Kinds of effects: each keeps what its row says."""

import numpy as np
import pytest

from helmbench.bench.faults import REGIME, TAXONOMY, UNFORESEEN, VESSELS, Effect, kind_of, kinds, names_of
from helmbench.bench.faults.effects import weather
from helmbench.bench.faults.effects.base import Setting
from helmbench.bench.faults.frames import plan_of
from helmbench.bench.faults.ships import ship
from helmbench.bench.faults.simulator import RunPlan
from helmbench.checks.base import SensorError
from helmbench.diagnosis.causes.base import Cause
from helmbench.diagnosis.causes.registry import causes
from helmbench.models.errors import BadInput


def drawn(name: str, rng: np.random.Generator):
    """The first ship that can carry a kind, and an effect on it."""
    kind = kind_of(name)
    carrier = next(ship(vessel) for vessel in VESSELS if kind.carried_by(ship(vessel)))
    return carrier, Effect(name, kind.draw(Setting(carrier, 600.0, 3, 2, lambda: (1.0, 2.0)), rng))


def test_an_identifier_is_taken_once(monkeypatch: pytest.MonkeyPatch) -> None:
    twice = weather.weather(id="rudder_fault", units={"speed": "m/s", "from": "rad"}, size=lambda ship: 1.0)
    monkeypatch.setattr(weather, "ROWS", (*weather.ROWS, twice))
    kinds.cache_clear()
    with pytest.raises(BadInput, match="effect 'rudder_fault' is defined twice"):
        kinds()
    kinds.cache_clear()


def test_every_cause_of_the_diagnosis_has_an_effect_and_the_other_way_round() -> None:
    others = {"base_coefficients", *names_of(REGIME)}  # the base model itself is another, or an effect acts in a regime
    of_checks = (c.id for c in causes().values() if isinstance(c, SensorError) and not isinstance(c, Cause))
    others |= {*of_checks, "ship_scale", "rudder_sensor_play", "rudder_sensor_delay"}  # planted in tests/diagnosis
    assert set(names_of(TAXONOMY)) == set(causes()) - others - {"heading_lag", "heading_zero", "impossible_samples"}
    assert len(names_of(UNFORESEEN)) >= 8


def test_ranks_are_those_of_the_order() -> None:
    ranks = [kind.rank for kind in kinds().values()]
    assert ranks == sorted(set(ranks))


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(BadInput, match="unknown effect 'gremlins'"):
        kind_of("gremlins")


@pytest.mark.parametrize("name", kinds())
def test_a_drawn_effect_has_its_units_and_acts_somewhere(name: str, rng: np.random.Generator) -> None:
    carrier, effect = drawn(name, rng)
    kind = effect.kind
    assert set(kind.units) | set(kind.whole) | {"channel"} >= set(effect.parameters)
    assert set(kind.sized) <= set(effect.parameters) and set(kind.directions) <= set(kind.units)
    plan = plan_of(carrier, (effect,), 0)
    unchanged = RunPlan(carrier)
    fields = ("terms", "chain", "extra", "wave", "sensors")
    assert plan.ship is not carrier or any(getattr(plan, f) != getattr(unchanged, f) for f in fields)


@pytest.mark.parametrize("name", [name for name, kind in kinds().items() if kind.sized])
def test_a_size_grows_to_its_cap(name: str, rng: np.random.Generator) -> None:
    _, effect = drawn(name, rng)
    size = effect.kind.sized[0]
    now, more, most = (abs(e.at(0)[size]) for e in (effect, effect.scaled(1.1), effect.scaled(1e9)))
    assert more == pytest.approx(now / 1.1 if effect.kind.inverse else 1.1 * now)
    assert most == effect.kind.cap or np.isinf(effect.kind.cap)


def test_numbers_are_counted_record_by_record() -> None:
    wind = Effect("wind", {"speed": (5.0,) * 5, "from": (0.1,) * 5})
    assert [wind.count(n) for n in (1, 3, 5)] == [2, 6, 10]
    assert Effect("memory", {"constants": (1.0,) * 6, "size": 0.1}).count(3) == 1
    assert Effect("rudder_sign", {}).count(3) == 0
