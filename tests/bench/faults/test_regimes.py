"""Effects that act in a part of the run only: where they act, and how a stated regime is compared with that."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import REGIME, VESSELS, Effect, FaultCase, equations, inject, kind_of, names_of
from helmbench.bench.faults.effects.base import Setting
from helmbench.bench.faults.regimes import SIDES, VARIABLES, TrueRegime, f1
from helmbench.bench.faults.ships import ship
from helmbench.bench.faults.simulator import straight
from helmbench.datasets.record import Record, RecordMeta

SHORT = {"duration_s": 300.0, "train": ("zigzag:20/20", "turn:35:port"), "held_out": ("zigzag:10/10",), "noise": 0.0}


def case_of(vessel, effects, seed=3, **facts):
    time = {} if ship(vessel).clock > 0.5 else {"duration_s": 80.0}
    return inject(FaultCase(vessel, effects=effects, **(SHORT | time | facts)), np.random.default_rng(seed))


def motion(case):
    """Yaw rate, heading and speed of the first training record."""
    run = case.true_motion()[0]
    return np.column_stack([run.column(name) for name in ("yaw_rate_rad_s", "heading_rad", "surge_m_s")])


@pytest.mark.parametrize("name", names_of(REGIME))
@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7", "response-1", "cargo"])
def test_an_effect_begins_where_its_regime_does(name, vessel, rng):
    """Up to the first sample inside the records are those without the effect, and later they differ."""
    kind = kind_of(name)
    if not kind.carried_by(ship(vessel)):
        return
    effect = Effect(name, kind.draw(setting(vessel), rng)).scaled(3.0)
    found, clean = case_of(vessel, (effect,)), case_of(vessel, ())
    inside = [kind.regime(effect.at(0), ship(vessel)).inside(run) for run in clean.true_motion()]
    assert 0 < sum(map(np.sum, inside)) < sum(map(len, inside))
    for own, ours, theirs in zip(inside, found.train, clean.train, strict=True):
        channels = [c for c in ("yaw_rate_rad_s", "surge_m_s") if ours.has(c)]
        error = np.abs([ours.column(c) - theirs.column(c) for c in channels]).max(axis=0)
        first = int(np.argmax(own)) if own.any() else own.size
        assert np.all(error[: max(first - 1, 0)] == 0.0)
        assert not own.any() or np.max(error) > 0.0


def setting(vessel):
    return Setting(ship(vessel), 300.0, 2, 1, lambda: (0.0, 0.0))


def test_a_saturated_sensor_leaves_the_motion_as_it_is():
    effect = Effect("yaw_rate_saturation", {"limit": 0.01})
    found = case_of("mariner", (effect,))
    assert np.array_equal(motion(found), motion(case_of("mariner", ())))
    recorded, true = found.train[0].column("yaw_rate_rad_s"), motion(found)[:, 0]
    assert np.allclose(recorded, np.clip(true, -0.01, 0.01)) and np.max(np.abs(true)) > 0.01


def test_the_rudder_loses_the_stated_share_of_its_force():
    """Forces of a straight course under rudder, and the shares on both sides of the thresholds."""
    for vessel, force in (
        ("mariner", equations.mariner_force),
        ("s175", equations.s175_force),
        ("kvlcc2-l7", equations.kvlcc2_force),
    ):
        one = ship(vessel)
        s, x = equations.ship_numbers(one, 1.0, 1.0), straight(one)
        more = () if vessel == "mariner" else (1.0,)
        whole, none, kept = (
            np.array(force(one.coefficients, s, x[0], 0.0, 0.0, 0.3, share, *more)) for share in (1.0, 0.0, 0.7)
        )
        assert np.allclose(kept - none, 0.7 * (whole - none))
    p = equations.NO_TERMS._replace(rudder_loss=0.3, rudder_angle=0.26, wake_loss=0.2, wake_drift=0.1)
    assert [equations.rudder_kept(p, d) for d in (0.25, 0.27, -0.27)] == [1.0, 0.7, 0.7]
    assert [equations.wake_kept(p, 1.0, v) for v in (0.09, 0.11, -0.11)] == [1.0, 0.8, 0.8]


@pytest.fixture
def run():
    """A record of ten samples: rudder, drift, yaw rate, speed and time grow from one side to the other."""
    line = np.linspace(-0.9, 0.9, 10)
    channels = {
        "rudder_rad": line, "yaw_rate_rad_s": 0.1 * line, "surge_m_s": np.cos(line), "sway_m_s": -np.sin(line),
        "heading_rad": line,
    }  # fmt: skip
    return Record(np.arange(10.0), channels, "made-up", RecordMeta(positive_rudder="starboard"))


@pytest.mark.parametrize(
    ("regime", "samples"),
    [
        (TrueRegime("rudder", "above", 0.6), {0, 1, 8, 9}), (TrueRegime("rudder", "below", 0.2), {4, 5}),
        (TrueRegime("rudder", "port"), {0, 1, 2, 3, 4}), (TrueRegime("rudder", "starboard", 0.6), {8, 9}),
        (TrueRegime("drift", "above", 0.8), {0, 9}), (TrueRegime("drift", "starboard", 0.8), {9}),
        (TrueRegime("yaw_rate", "above", 0.06), {0, 1, 8, 9}), (TrueRegime("side", "port"), {0, 1, 2, 3, 4}),
        (TrueRegime("speed", "above", 0.5), set(range(10))), (TrueRegime("time", "above", 7.0), {8, 9}),
    ],
)  # fmt: skip
def test_samples_of_a_regime(run, regime, samples):
    assert set(np.flatnonzero(regime.inside(run)).tolist()) == samples


def test_a_rudder_that_is_positive_to_port_is_turned(run):
    turned = replace(run, meta=RecordMeta(positive_rudder="port"))
    assert np.array_equal(TrueRegime("rudder", "port").inside(turned), TrueRegime("rudder", "starboard").inside(run))


def test_a_stated_regime_is_read_and_nonsense_is_refused():
    told = {"variable": "rudder", "side": "above", "threshold": 0.25, "low": 0.24, "high": 0.27}
    assert TrueRegime.of(told) == TrueRegime("rudder", "above", 0.25)
    assert TrueRegime.of({"variable": "side", "side": "port", "threshold": None}) == TrueRegime("side", "port")
    for wrong in ({"variable": "moon", "side": "above"}, {"variable": "rudder", "side": "under"}):
        with pytest.raises(ValueError, match="variables are"):
            TrueRegime.of(wrong)
    assert len(VARIABLES) == 6 and len(SIDES) == 4


def test_f1_is_the_harmonic_mean_of_precision_and_recall(rng):
    true, said = rng.random(200) < 0.4, rng.random(200) < 0.5
    precision, recall = np.sum(true & said) / said.sum(), np.sum(true & said) / true.sum()
    assert f1(true, said) == pytest.approx(2 * precision * recall / (precision + recall))
    assert f1(true, true) == 1.0 and f1(true, ~true) == 0.0 and np.isnan(f1(true & False, true & False))


def test_all_vessels_carry_a_fault_in_a_regime():
    assert all(any(kind_of(name).carried_by(ship(v)) for name in names_of(REGIME)) for v in VESSELS)
