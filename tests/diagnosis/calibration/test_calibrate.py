"""Which numbers of a base model are wrong: changes are found, an exact base stays as it is."""

import json
from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Case, inject
from helmbench.datasets import measured
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.diagnosis.gain.guard import WORSE
from helmbench.estimation.diagnosis_only.mixed_effects.problem import pooled, problem, squares
from helmbench.models.coefficient_groups import groups_of, grown
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import model_to_json, resolve

from ...injections import fewest

MANOEUVRES = ("zigzag:10/10", "zigzag:20/20:port", "turn:20", "zigzag:25/5", "turn:25:port")


FEW = {"propeller_thrust", "resistance", "wake_and_thrust_deduction", "neutral_rudder_angle", "asymmetry"}
FEW |= {"rudder_large_angle"}
"""Groups of one or two numbers: what is wrong, and what acts on speed or heading as that does."""


def runs(model, rng, trims, texts=MANOEUVRES):
    """Noisy runs of a ship whose rudder has another neutral angle in each."""
    out = []
    for text, trim in zip(texts, trims, strict=True):
        run = record_run(model, parse_manoeuvre(text), duration_s=70.0, dt_s=0.2)
        run = run.with_channels(rudder_rad=run.rudder() - trim)
        out.append(replace(apply(run, parse_noise("low"), rng), name=text))
    return out


def altered(model, resistance, thrust):
    """The model with another resistance and propeller thrust."""
    groups = [g for g in groups_of(model) if g.id == "propeller_thrust"]
    new = grown(model, groups)
    values = new.coefficients.copy()
    values[new.coordinates.index("R_0")] *= 1.0 + resistance
    values[new.coordinates.index("thrust_scale")] = thrust
    return new.with_coefficients(values)


@pytest.fixture(scope="module")
def ship():
    return resolve("kvlcc2-l7")


@pytest.fixture(scope="module")
def found(ship):
    """A calibration of records with 25 % more resistance and a common neutral rudder angle of 1 deg."""
    rng = np.random.default_rng(20261122)
    trims = np.deg2rad(1.0 + 0.2 * rng.normal(size=len(MANOEUVRES)))
    records = runs(altered(ship, 0.25, 0.0), rng, trims)
    return calibrate(ship, records[:-1], records[-1:])


def test_changes_are_named_with_their_sizes(found):
    moved = {m.name: m for m in found.moved}
    print(found.moved, found.steps)
    named = {name for step in found.steps for name in (step.group, *step.tied_with)}
    assert {"resistance", "neutral_rudder_angle"} <= named
    assert found.verdict == "named"
    assert moved["rudder_offset"].after == pytest.approx(np.deg2rad(1.0), abs=np.deg2rad(0.3))
    assert moved["rudder_offset"].low < moved["rudder_offset"].after < moved["rudder_offset"].high


def few_like_zigzags_name_what_is_wrong(ship, rng):
    """Propeller, resistance and neutral angle off as in the measured runs of this ship; zigzags of one side only."""
    true = altered(ship, -0.25, 0.33)
    texts = ("zigzag:15/5", "zigzag:20/5", "zigzag:25/5", "zigzag:20/10")
    records = runs(true, rng, np.deg2rad(0.9 + 0.05 * rng.normal(size=4)), texts)
    found = calibrate(ship, records[:3], records[3:])
    print(found.verdict, [step.group for step in found.steps], found.worse)
    half = all(found.after[c][1] < 0.5 * found.before[c][1] for c in ("surge_m_s", "yaw_rate_rad_s"))
    assert half and found.verdict == "named" and found.worse == ()
    return {step.group for step in found.steps} <= FEW


def test_few_like_zigzags_name_what_is_wrong_and_no_group_of_many_numbers(ship, rng):
    """In the others the rudder's inflow, five numbers, takes the place of the neutral angle: three records are few."""
    right = [few_like_zigzags_name_what_is_wrong(ship, rng) for _ in range(5)]
    assert sum(right) >= fewest(5, 0.85)


def test_left_out_and_held_out_errors_fall(found):
    for column in ("surge_m_s", "yaw_rate_rad_s", "heading_rad"):
        for before, after in zip(found.before[column], found.after[column], strict=True):
            assert after < 0.5 * before
    assert found.worse == ()


def test_shares_add_up(found):
    for share in found.shares.values():
        assert share.coefficients + share.trim + share.noise + share.remaining == pytest.approx(1.0)
    assert found.shares["surge_m_s"].coefficients > 0.8


def test_the_extended_model_gives_the_told_errors_when_it_is_read_again(found, ship, tmp_path):
    model_to_json(found.extended, tmp_path / "extended.json")
    again = resolve(tmp_path / "extended.json")
    rng = np.random.default_rng(20261122)
    trims = np.deg2rad(1.0 + 0.2 * rng.normal(size=len(MANOEUVRES)))
    held = runs(altered(ship, 0.25, 0.0), rng, trims)[-1]
    p = problem(again, [held])
    errors = pooled([squares(p, again.theta, p.runs[0])])
    told = [found.after[column][1] for column in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s", "heading_rad")]
    assert errors == pytest.approx(told, rel=1e-6)


def test_the_outcome_is_plain_data(found):
    document = json.loads(json.dumps(found.to_json()))
    assert document["verdict"] == "named" and document["model"] == "kvlcc2-l7"
    assert [step["group"] for step in document["steps"]] == [step.group for step in found.steps]
    assert len(document["next_runs"]) == 3


def exact_base_stays_as_it_is(ship, rng):
    """Neutral rudder angles that differ between records, and are none on average."""
    trims = np.deg2rad(0.1 * rng.normal(size=len(MANOEUVRES)))
    found = calibrate(ship, runs(ship, rng, trims - trims.mean()))
    print(found.verdict, found.moved, found.steps, found.refused)
    return found.verdict == "adequate" and found.moved == () and np.array_equal(found.extended.theta, ship.theta)


def test_an_exact_base_stays_as_it_is(ship, rng):
    """Of 62 one did not: a trim of one record counted as that of a regime."""
    kept = [exact_base_stays_as_it_is(ship, rng) for _ in range(12)]
    assert sum(kept) >= fewest(12, 0.95)


def test_records_of_an_independent_simulator_are_adequate(rng):
    case = inject(Case("mariner", duration_s=600.0, dt_s=2.0), rng)
    found = calibrate(resolve("mariner"), case.train)
    print(found.moved, found.steps)
    assert found.moved == () or max(step.gain for step in found.steps) < 0.3


def test_a_single_record_is_cut_into_pieces(ship, rng):
    """What is wrong shows in the differences between the pieces, which are few: some draws are not significant."""
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:20/20"), duration_s=240.0, dt_s=0.2)
    all_found = [calibrate(ship, [apply(run, parse_noise("low"), rng)]) for _ in range(4)]
    assert all(len(found.runs) >= 3 for found in all_found)
    better = [found.after["surge_m_s"][0] < 0.7 * found.before["surge_m_s"][0] for found in all_found]
    assert sum(better) >= fewest(4, 0.95)


def test_records_without_a_heading_and_with_a_long_gap_are_calibrated(ship, rng):
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:20/20"), duration_s=420.0, dt_s=0.2)
    run = apply(run, parse_noise("low"), rng).with_channels(heading_rad=None)
    gap = (run.time_s > 100.0) & (run.time_s < 130.0)
    broken = replace(run, time_s=run.time_s[~gap], channels={k: v[~gap] for k, v in run.channels.items()})
    found = calibrate(ship, [broken])
    assert len(found.runs) >= 3 and found.next_runs
    assert found.after["surge_m_s"][0] < found.before["surge_m_s"][0]
    assert all(np.diff(trace.time).max() < 5.0 for trace in found.traces)


def test_a_single_run_of_twelve_ship_lengths_is_calibrated(ship, rng):
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:10/10"), duration_s=72.0, dt_s=0.2)
    found = calibrate(ship, [apply(run, parse_noise("low"), rng)])
    assert len(found.runs) == 3
    assert found.after["surge_m_s"][0] <= WORSE * found.before["surge_m_s"][0]


def test_what_cannot_be_calibrated_is_refused(ship):
    short = record_run(ship, parse_manoeuvre("zigzag:10/10"), duration_s=30.0, dt_s=0.2)
    with pytest.raises(CannotFit, match="no part can be left out"):
        calibrate(ship, [short])
    with pytest.raises(BadInput, match="no training record"):
        calibrate(ship, [])
    with pytest.raises(BadInput, match="no coefficients"):
        calibrate(ship.blanked(), [short])
    with pytest.raises(BadInput, match="states no groups"):
        calibrate(resolve("remus"), [short])


def test_measured_kvlcc2_runs_need_more_thrust(ship):
    """The published simulation pairs a propeller curve with another diameter: more thrust."""
    folder = measured.data_dir() / measured.dataset("kvlcc2-hsva").folder
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")
    stems = ("Z_05_01", "Z_15_05", "Z_20_10_S", "Z_35_05")
    found = calibrate(ship, [measured.load("kvlcc2-hsva", stem).thinned(4) for stem in stems])
    moved = {m.name: m for m in found.moved}
    print(found.steps)
    assert moved["thrust_scale"].after == pytest.approx(0.33, abs=0.04)
    assert found.after["surge_m_s"][0] < 0.7 * found.before["surge_m_s"][0]
