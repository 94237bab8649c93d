"""Records of ships whose base model is right or wrong in a known way, and how often a calibration says so."""

from dataclasses import replace

import numpy as np

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.models.coefficient_groups import groups_of, grown
from helmbench.models.model import resolve

from .injections import Expectation

SHIP = "kvlcc2-l7"
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


def few_like_zigzags_name_what_is_wrong_and_no_group_of_many_numbers(rng):
    """Propeller, resistance and neutral angle off as in the measured runs of this ship; zigzags of one side only.

    In the other draws the rudder's inflow, five numbers, takes the neutral angle's place: three records are few."""
    ship = resolve(SHIP)
    true = altered(ship, -0.25, 0.33)
    texts = ("zigzag:15/5", "zigzag:20/5", "zigzag:25/5", "zigzag:20/10")
    records = runs(true, rng, np.deg2rad(0.9 + 0.05 * rng.normal(size=4)), texts)
    found = calibrate(ship, records[:3], records[3:])
    print(found.verdict, [step.group for step in found.steps], found.worse)
    half = all(found.after[c][1] < 0.5 * found.before[c][1] for c in ("surge_m_s", "yaw_rate_rad_s"))
    assert half and found.verdict in ("named", "tied") and found.worse == ()
    return {step.group for step in found.steps} <= FEW


def an_exact_base_stays_as_it_is(rng):
    """Neutral rudder angles that differ between records, and are none on average.

    Of 62 draws one did not: a trim of one record counted as that of a regime."""
    ship = resolve(SHIP)
    trims = np.deg2rad(0.1 * rng.normal(size=len(MANOEUVRES)))
    found = calibrate(ship, runs(ship, rng, trims - trims.mean()))
    print(found.verdict, found.moved, found.steps)
    return found.verdict == "adequate" and found.moved == () and np.array_equal(found.extended.theta, ship.theta)


def a_single_record_is_cut_into_pieces(rng):
    """What is wrong shows in the differences between the pieces, which are few: some draws are not significant."""
    ship = resolve(SHIP)
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:20/20"), duration_s=240.0, dt_s=0.2)
    found = calibrate(ship, [apply(run, parse_noise("low"), rng)])
    assert len(found.runs) == 1
    return found.after["surge_m_s"][0] < 0.7 * found.before["surge_m_s"][0]


CALIBRATED = (
    Expectation(few_like_zigzags_name_what_is_wrong_and_no_group_of_many_numbers, 0.85),
    Expectation(an_exact_base_stays_as_it_is, 0.95),
    Expectation(a_single_record_is_cut_into_pieces, 0.95),
)
