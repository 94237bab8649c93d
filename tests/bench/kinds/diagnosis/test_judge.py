"""Scores of hand-made diagnoses: every outcome, tie, wrong name and size, one by one."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import TAXONOMY, Effect, FaultCase, Injected, inject, kind_of, names_of
from helmbench.bench.faults.effects.base import Setting
from helmbench.bench.faults.frames import Frames
from helmbench.bench.faults.sensing import noise_sd
from helmbench.bench.faults.ships import VESSELS, ship
from helmbench.bench.kinds.diagnosis.judge import (
    OUTCOMES,
    compare,
    description,
    detectable,
    gain,
    judge,
    size_rows,
    truth_errors,
    wrapped,
)
from helmbench.datasets.record import Record, RecordMeta
from helmbench.diagnosis.result import RemainingForce

OFFSET = ("rudder_offset",)
PAIR = ("rudder_offset", "wind")


@pytest.mark.parametrize(
    ("group", "injected", "findings", "verdict", "outcome", "wrong", "tie"),
    [
        ("injected", OFFSET, ["rudder_offset"], None, "alone", False, 1),
        ("injected", OFFSET, ["rudder_offset/constant_force"], None, "tie", False, 2),
        ("injected", OFFSET, ["constant_force/rudder_offset/wind"], None, "tie", False, 3),
        ("injected", OFFSET, ["wind"], None, "wrong_first", True, None),
        ("injected", OFFSET, ["wind/current"], None, "wrong_first", False, None),
        ("injected", OFFSET, ["rudder_offset", "wind"], None, "alone", True, 1),
        ("injected", OFFSET, ["wind", "rudder_offset"], None, "wrong_first", True, 1),
        ("injected", OFFSET, ["wind"], "unexplained", "wrong_first", False, None),
        ("injected", OFFSET, [], None, "missed", False, None),
        ("injected", OFFSET, [], "unexplained", "missed", False, None),
        ("pair", PAIR, ["wind", "rudder_offset"], None, "both", False, 1),
        ("pair", PAIR, ["wind/current", "constant_force/rudder_offset"], None, "both", False, 2),
        ("pair", PAIR, ["wind/rudder_offset"], None, "one", False, 2),
        ("pair", PAIR, ["wind/rudder_offset", "rudder_offset"], None, "both", False, 2),
        ("pair", PAIR, ["wind"], None, "one", False, 1),
        ("pair", PAIR, ["current"], None, "wrong_first", True, None),
        ("null", (), [], None, "adequate", False, None),
        ("null", (), ["wind"], None, "false_alarm", True, None),
        ("null", (), ["wind/current"], None, "false_alarm", False, None),
        ("null", (), [], "unexplained", "false_alarm", False, None),
        ("anticipated", ("memory",), [], "unexplained", "unexplained", False, None),
        ("unforeseen", ("memory",), ["wind"], "unexplained", "unexplained", False, None),
        ("unforeseen", ("memory",), ["wind"], None, "named", True, None),
        ("unforeseen", ("memory",), [], None, "missed", False, None),
        ("planted-null", OFFSET, ["rudder_offset"], None, "named", True, None),
        ("planted-null", OFFSET, [], "unexplained", "unexplained", False, None),
    ],
)
def test_every_outcome(diagnosis_of, group, injected, findings, verdict, outcome, wrong, tie):
    scored = judge(diagnosis_of(*findings, verdict=verdict), group, injected)
    assert scored["outcome"] == outcome in OUTCOMES
    assert scored["confident_wrong"] == wrong and scored["tie_size"] == tie
    assert scored["false_alarm"] == (outcome == "false_alarm" if group == "null" else None)
    assert scored["named"].split("+") == (findings or [""]) or "/" in scored["named"]


@pytest.mark.parametrize(
    ("group", "base", "findings", "names", "false"),
    [
        ("injected", "exact", ["rudder_offset", "shallow_water"], 2, 1),
        ("injected", "off-10", ["rudder_offset", "shallow_water", "wind"], 3, 1),
        ("planted-null", "unstated", ["rudder_offset/wind", "base_coefficients"], 2, 2),
        ("null", "unstated", ["base_coefficients"], 1, 1),
        ("null", "off-10", ["base_coefficients"], 1, 0),
        ("null", "exact", [], 0, 0),
    ],
)
def test_names_that_are_false_are_counted(diagnosis_of, group, base, findings, names, false):
    """Numbers of an imperfect base model are rightly named, those of a correct one are not."""
    scored = judge(diagnosis_of(*findings), group, OFFSET if group != "null" else (), base)
    assert (scored["names"], scored["false_names"]) == (names, false)


def test_what_fits_best_of_an_unexplained_error_is_no_stated_name(diagnosis_of):
    scored = judge(diagnosis_of("wind", verdict="unexplained"), "unforeseen", ("memory",))
    assert (scored["named"], scored["names"], scored["false_names"]) == ("wind", 0, 0)


@pytest.mark.parametrize(
    ("kind", "constants", "variables", "right"),
    [
        ("harmonic", (1.0, 3.0, 2.0, 0.0, 0.0, 0.0), ("heading",), True),
        ("harmonic", (1.0, 3.0, 2.0, 0.0, 0.0, 0.0), ("time",), False),
        ("memory", (1.0, 1.0, 2.0, 20.0, 0.0, 0.0), ("past of the yaw rate",), True),
        ("memory", (1.0, 2.0, 2.0, 20.0, 0.0, 0.0), ("past of the yaw rate",), False),
        ("pulse", (1.0, 100.0, 2.0, 20.0, 0.0, 0.0), (), False),
    ],
)
def test_an_unknown_effect_is_described_by_its_variable(diagnosis_of, kind, constants, variables, right):
    force = RemainingForce("N", variables, "a yaw moment", 0.9, {}, (), True, "a current", "turn")
    diagnosis = replace(diagnosis_of(verdict="described"), remaining=(force,) if variables else ())
    scored = description(diagnosis, [Effect(kind, {"constants": constants, "size": 0.1})])
    assert scored == {"described": "/".join(variables), "right_variable": right}


def test_no_variable_is_right_where_none_is_known(diagnosis_of):
    assert description(diagnosis_of(), [Effect("rudder_offset", {"delta0": 0.1})])["right_variable"] is None


def test_gains_keep_known_channels_only(diagnosis_of):
    assert gain(diagnosis_of(ratio=0.5)) == {"rmse_before_heading_rad": 1.0, "rmse_after_heading_rad": 0.5}


def test_a_size_is_covered_inside_its_interval_and_a_direction_on_the_circle(size):
    assert compare(size("b", 1.0, 0.3), 1.2)["covered"] and not compare(size("b", 1.0, 0.3), 1.4)["covered"]
    assert compare(size("b", 1.0, 0.3), 2.0)["rel_error"] == pytest.approx(0.5)
    assert compare(size("from", np.pi - 0.05, 0.2), -np.pi + 0.05, circular=True)["covered"]
    assert not compare(size("from", np.pi - 0.05, 0.05), -np.pi + 0.05, circular=True)["covered"]
    assert compare(size("from", 1.0, 0.1), 1.0, circular=True)["rel_error"] is None


def test_angles_are_wrapped(rng):
    angle = rng.uniform(-20, 20)
    assert -np.pi <= wrapped(angle) < np.pi and np.sin(wrapped(angle)) == pytest.approx(np.sin(angle))


def injected_of(effect, vessel="mariner", power=50.0):
    records = [
        Record(np.arange(3.0), {"rudder_rad": np.zeros(3)}, name, RecordMeta())
        for name in ("train-1", "train-2", "held_out-3")
    ]
    frames = Frames(FaultCase(vessel), None, np.zeros(0), np.zeros(0))
    return Injected(frames, records[:2], records[2:], (effect,), power)


SHORT = {"duration_s": 120.0, "train": ("turn:20",), "held_out": ("zigzag:20/20", "steps:20deg/30s")}


def test_the_true_ship_is_off_by_noise_and_gusts_alone(rng):
    """Without gusts and noise nothing is left, with noise its standard deviation, with gusts more."""
    still = truth_errors(
        inject(FaultCase("mariner", ("rudder_offset", "yaw_rate_bias"), 200.0, noise=0.0, **SHORT), rng)
    )
    assert len(still) == 6 and max(still.values()) < 1e-12
    seed = int(rng.integers(2**32))
    print("seed", seed)
    calm = inject(FaultCase("mariner", ("rudder_offset",), 200.0, **SHORT), np.random.default_rng(seed))
    noise = noise_sd(calm.case.ship, 1.0)
    found = truth_errors(calm)
    assert found["rmse_truth_surge_m_s"] == pytest.approx(noise["surge_m_s"], rel=0.2)
    assert found["rmse_truth_heading_rad"] == pytest.approx(noise["heading_rad"], rel=0.2)
    strong = FaultCase("mariner", gusts="slow", gust_level=np.deg2rad(8.0), **SHORT)
    gusty = truth_errors(inject(strong, np.random.default_rng(seed)))
    assert gusty["rmse_truth_heading_rad"] > 2.0 * found["rmse_truth_heading_rad"]


def rows_of(diagnosis, case):
    names = ([record.name for record in side] for side in (case.train, case.held_out))
    return size_rows(diagnosis, case.effects, case.case.ship, *names)


def test_sizes_are_compared_record_by_record(diagnosis_of, size):
    effect = Effect("wind", {"speed": (5.0, 7.0, 9.0), "from": (0.1, 0.2, 0.3)})
    stated = [size("speed", 5.2, 1.0, "train-1"), size("speed", 5.2, 1.0, "train-2"), size("from", 0.1, 0.1, "train-1")]
    rows = rows_of(diagnosis_of("wind", sizes=stated), injected_of(effect))
    assert [(row["record"], row["parameter"], row["true"], row["covered"]) for row in rows] == [
        ("train-1", "speed", 5.0, True), ("train-2", "speed", 7.0, False), ("train-1", "from", 0.1, True),
    ]  # fmt: skip
    assert rows_of(diagnosis_of("current/wind", sizes=stated), injected_of(effect)) == []


def test_a_shifted_coefficient_is_compared_only_where_it_is_the_true_one():
    effect, hull = Effect("coefficient_shift", {"name": "Nr", "fraction": 0.1}), ship("mariner")
    assert effect.kind.truths(effect.at(0), hull, {"coefficient": "Nr"})["fraction"] == 0.1
    assert "fraction" not in effect.kind.truths(effect.at(0), hull, {"coefficient": "Nv"})


def test_what_is_stated_in_other_terms_is_translated():
    found = kind_of("shallow_water").truths({"depth_ratio": 2.0}, ship("mariner"), {})
    assert found == {"depth_ratio": 2.0, "draught_over_depth": 0.5}
    found = kind_of("second_order_lead").truths({"T2": 2.0, "T3": 0.5}, ship("response-1"), {})
    assert found["lead"] == 0.75


def test_detectable_counts_the_numbers_of_an_effect():
    one, six = Effect("rudder_offset", {"delta0": 0.01}), Effect("wind", {"speed": (5.0,) * 3, "from": (0.1,) * 3})
    assert detectable(injected_of(one, power=33.0)) and not detectable(injected_of(one, power=30.0))
    assert not detectable(injected_of(six, power=33.0)) and detectable(injected_of(six, power=60.0))
    assert detectable(injected_of(Effect("rudder_sign", {}), power=np.nan))


@pytest.mark.parametrize("cause", [name for name in names_of(TAXONOMY) if kind_of(name).sized])
def test_every_sized_cause_has_truths_to_compare_with(cause, rng):
    kind = kind_of(cause)
    hull = next(ship(v) for v in VESSELS if kind.carried_by(ship(v)))
    effect = Effect(cause, kind.draw(Setting(hull, 600.0, 3, 2, lambda: (0.0, 0.0)), rng))
    truths = kind.truths(effect.at(0), hull, {})
    assert truths and all(isinstance(value, float) for value in truths.values())
