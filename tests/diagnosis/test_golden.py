"""Fixed cases give the stored outcomes: verdict, causes, ties, sizes, bank and gain of diagnoses, calibrations, checks.

A change that moves them is looked at and explained; `python -m tests.diagnosis.test_golden [CASE ...]` stores the new
outcomes (of these cases, else of all) and prints the difference.
"""

import difflib
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from helmbench import calibrate, check
from helmbench.bench.kinds.diagnosis.bases import base_model
from helmbench.datasets.measured import data_dir, load
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

from ..expectations.injections import injected
from ..nightly_marks import nightly_but
from .documents import faults

STORED = Path(__file__).with_name("golden.json")
KNOWN = {
    "clean": ("mariner", (), "large", "slow"),
    "rudder-offset": ("mariner", ("rudder_offset",), "moderate", "none"),
    "backlash": ("s175", ("rudder_backlash",), "large", "fast"),
    "gyro-scale": ("kvlcc2-l7", ("yaw_rate_scale",), "moderate", "none"),
    "rudder-delay": ("response-1", ("rudder_delay",), "large", "none"),
    "two": ("mariner", ("rudder_effectiveness", "current"), "large", "none"),
    "outside-the-bank": ("cargo", ("pulse",), "large", "none"),
}
"""Exact base models: name -> ship, effects, strength, gusts."""
DEFAULT = {
    "clean-5": ("mariner", (), "off-5"),
    "clean-10": ("kvlcc2-l7", (), "off-10"),
    "clean-20": ("response-1", (), "off-20"),
    "offset-5": ("mariner", ("rudder_offset",), "off-5"),
    "offset-20": ("response-1", ("rudder_offset",), "off-20"),
    "delay-10": ("response-1", ("rudder_delay",), "off-10"),
    "delay-5": ("mariner", ("rudder_delay",), "off-5"),
    "gyro-bias-10": ("cargo", ("yaw_rate_bias",), "off-10"),
    "gyro-bias-20": ("mariner", ("yaw_rate_bias",), "off-20"),
    "current-5": ("kvlcc2-l7", ("current",), "off-5"),
    "current-10": ("mariner", ("current",), "off-10"),
    "waves-10": ("mariner", ("wave_motion",), "off-10"),
    "waves-20": ("cargo", ("wave_motion",), "off-20"),
    "two-10": ("mariner", ("rudder_offset", "yaw_rate_scale"), "off-10"),
    "two-5": ("cargo", ("rudder_offset", "rudder_delay"), "off-5"),
    "shallow-5": ("mariner", ("shallow_water",), "off-5"),
}
"""Base models that are off, by the default route: name -> ship, effects, base."""
IDENTIFIED = {
    "identified-clean": ("nomoto-1-cubic", "response-1", ()),
    "identified-offset": ("nomoto-1", "response-1", ("rudder_offset",)),
}
"""Base models from the records themselves: name -> family, ship, effects."""
MEASURED = {
    "measured-kvlcc2": ("kvlcc2-l7", "kvlcc2-hsva", ("Z_10_05", "Z_35_05"), ("Z_15_05",), 40),
    "measured-esso-osaka": (
        "esso-osaka-l3",
        "esso-osaka",
        ("zigzag_31-Jul-2020_13_42_53", "zigzag_31-Jul-2020_13_57_45"),
        ("zigzag_31-Jul-2020_14_10_05",),
        10,
    ),
}
"""Measured records: name -> model, set, training and held-out records, every which sample."""
CALIBRATED = {
    "calibrated-resistance": ("kvlcc2-l7", {"R_0": 1.3}),
    "calibrated-yaw": ("s175", {"Nur": 0.7}),
    "calibrated-correct": ("mariner", {}),
}
"""Calibrations: name -> ship, factors on numbers of the base model."""
CHECKED = {
    "checked-clean": (),
    "checked-gyro-bias": ("yaw_rate_bias",),
    "checked-gyro-scale": ("yaw_rate_scale",),
    "checked-heading-delay": ("heading_delay",),
    "checked-speed-scale": ("speed_scale",),
    "checked-outliers": ("outliers",),
    "checked-swap": ("channel_swap",),
    "checked-earth-frame": ("earth_frame_velocity",),
}
"""Checks of records of the Mariner: name -> effects."""
CASES = (*KNOWN, *DEFAULT, *IDENTIFIED, *MEASURED, *CALIBRATED, *CHECKED)
KEPT = (
    *("clean", "outside-the-bank", "gyro-bias-10", "identified-clean", "identified-offset", "calibrated-correct"),
    *CHECKED,
)
"""Cases of `make test`: every route."""
UNREMARKABLE = ("named", "tied", "not_significant", "not_testable")
"""Statuses of the bank that say no more than the causes do."""
DIGITS = 0.1
"""Tolerance of a size, in lengths of its interval."""
CLOSE = 0.03
"""Relative tolerance of an error."""


def generator(name):
    return np.random.default_rng(int.from_bytes(name.encode(), "little") % 2**32)


def outcome(name):
    """What is stored of a case: short texts, so that a difference can be read."""
    rng = generator(name)
    if name in CHECKED:
        return of_check(check(injected("mariner", CHECKED[name], rng).train))
    if name in CALIBRATED:
        vessel, factors = CALIBRATED[name]
        base, case = resolve(vessel), injected(vessel, (), rng)
        parameters = {n: value * factors.get(n, 1.0) for n, value in base.parameters.items()}
        wrong = base.with_coefficients(base.from_parameters(parameters))
        return of_calibration(calibrate(wrong, case.train, case.held_out[:1]))
    found = diagnosed(name, rng)
    assert faults(found.to_json()) == []
    return of_diagnosis(found)


def diagnosed(name, rng):
    """The diagnosis of a case."""
    if name in KNOWN:
        vessel, causes, strength, gusts = KNOWN[name]
        case = injected(vessel, causes, rng, strength, gusts)
        return diagnose(resolve(vessel), case.train, case.held_out[:1], Options(coefficient_sd=0.0))
    if name in DEFAULT:
        vessel, causes, base = DEFAULT[name]
        case = injected(vessel, causes, rng)
        return diagnose(base_model(base, vessel, rng), case.train[:2], case.held_out[:1])
    if name in IDENTIFIED:
        family, vessel, causes = IDENTIFIED[name]
        case = injected(vessel, causes, rng)
        return diagnose(resolve(family), case.train, case.held_out[:1], Options(base_parameters="identify"))
    model, data, train, held_out, every = MEASURED[name]
    records = [[thinned(load(data, stem), every) for stem in stems] for stems in (train, held_out)]
    return diagnose(resolve(model), *records)


def thinned(record, every):
    return replace(record, time_s=record.time_s[::every], channels={k: v[::every] for k, v in record.channels.items()})


def of_diagnosis(found):
    """Verdict, causes, what is remarkable in the bank, and errors of held-out records."""
    bank = {}
    for entry in found.bank:
        bank.setdefault(entry.status, []).append(entry.cause)
    return {
        "verdict": found.verdict,
        "causes": [text for f in found.causes for text in of_finding(f)],
        "bank": [
            f"{status}: {', '.join(sorted(bank[status]))}" for status in sorted(bank) if status not in UNREMARKABLE
        ],
        "remaining": [force.text for force in found.remaining],
        "gain": [change(channel, g.rmse_before, g.rmse_after) for channel, g in sorted(found.gain.items())],
    }


def of_finding(f):
    """A line for the cause and those that it is tied with, one for each size."""
    groups = f.details.get("groups")
    said = [f"{f.cause} / {', '.join(sorted(f.tied_with))}" if f.tied_with else f.cause]
    said[0] += f" ({', '.join(groups)})" if groups else ""
    return said + [
        f"  {f'{s.record}: ' if s.record else ''}{size(s.parameter, s.value, s.low, s.high)}" for s in f.sizes
    ]


def of_calibration(found):
    return {
        "verdict": found.verdict,
        "steps": [f"{s.group} / {', '.join(sorted(s.tied_with))}".removesuffix(" / ") for s in found.steps],
        "moved": [size(m.name, m.after, m.low, m.high) for m in found.moved],
        "gain": [change(c, found.before[c][1], found.after[c][1]) for c in sorted(found.after)],
    }


def of_check(found):
    """A line for each cause of the records together or of one, with whether it matters, and its sizes."""
    return {"findings": list(dict.fromkeys(text for f in found.findings for text in of_check_finding(f)))}


def of_check_finding(f):
    said = f"{f.cause} / {', '.join(sorted(f.tied_with))}".removesuffix(" / ") + ("" if f.material else " (immaterial)")
    of_all = [s for s in f.sizes if s.record is None and f.material]
    return [f"{', '.join(f.records)}: {said}", *(f"  {size(s.parameter, s.value, s.low, s.high)}" for s in of_all)]


def size(name, value, low, high):
    """A size with two digits of its interval."""
    digits = 1 - int(np.floor(np.log10(high - low))) if 0.0 < high - low < np.inf else 12
    value, low, high = (round(float(x), digits) for x in (value, low, high))
    return f"{name} {value:g} [{low:g}, {high:g}]"


def change(channel, before, after):
    """Errors before and after, with three digits."""
    return f"{channel} {before:.3g} -> {after:.3g}"


def text_of(found):
    """All outcomes as JSON text."""
    return json.dumps(found, indent=1, ensure_ascii=False) + "\n"


NUMBER = r"-?\d+\.?\d*(?:e[+-]?\d+)?"


def differences(found, stored):
    """Lines that differ, in words and numbers, as of `diff`; empty where only digits within tolerance do."""
    ours, theirs = (text_of(one).splitlines() for one in (found, stored))
    if len(ours) == len(theirs) and all(map(same, ours, theirs)):
        return []
    return [line for line in difflib.unified_diff(theirs, ours, "stored", "found", lineterm="", n=1)]


def same(line, stored):
    """Whether two lines have the same words, and numbers within tolerance."""
    pattern = rf"(?<= ){NUMBER}(?= \[| ->|\")|(?<=\[){NUMBER}|{NUMBER}(?=\])"
    if re.sub(pattern, "#", line) != re.sub(pattern, "#", stored):
        return False
    ours, theirs = ([float(x) for x in re.findall(pattern, one)] for one in (line, stored))
    if len(theirs) == 3:
        return np.allclose(ours, theirs, rtol=0.0, atol=DIGITS * (theirs[2] - theirs[1]))
    return np.allclose(ours, theirs, rtol=CLOSE, atol=0.0)


def at_hand(name):
    """Whether the records of a case are on this machine."""
    folders = {"kvlcc2-hsva": "kvlcc2/hsva", "esso-osaka": "esso_osaka"}
    return name not in MEASURED or (data_dir() / folders[MEASURED[name][1]]).exists()


@pytest.mark.parametrize("name", nightly_but([name for name in CASES if at_hand(name)], *KEPT))
def test_outcome_is_the_stored_one(name):
    found, stored = outcome(name), json.loads(STORED.read_text(encoding="utf-8"))[name]
    assert differences(found, stored) == []


def test_a_difference_is_told_and_digits_are_not():
    stored = {"causes": ["wind / current", "  speed 5.1 [5, 5.2]"], "gain": ["heading_rad 0.1 -> 0.05"]}
    near = {"causes": ["wind / current", "  speed 5.11 [5, 5.21]"], "gain": ["heading_rad 0.101 -> 0.0505"]}
    far = [
        {**stored, "causes": ["wind", "  speed 5.1 [5, 5.2]"]},
        {**stored, "causes": ["wind / current", "  speed 5.15 [5, 5.2]"]},
        {**stored, "gain": ["heading_rad 0.1 -> 0.06"]},
        {**stored, "causes": stored["causes"][:1]},
    ]
    assert differences(near, stored) == [] and all(differences(one, stored) for one in far)
    assert '+  "heading_rad 0.1 -> 0.06"' in differences(far[2], stored)


def store(names):
    """Compute outcomes, print how they differ from the stored ones, and store them."""
    old = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {}
    new = {name: outcome(name) if name in names and at_hand(name) else old.get(name) for name in CASES}
    new = {name: one for name, one in new.items() if one is not None}
    print("\n".join(differences(new, old)) or "no difference")
    STORED.write_text(text_of(new), encoding="utf-8")


if __name__ == "__main__":
    store(sys.argv[1:] or CASES)
