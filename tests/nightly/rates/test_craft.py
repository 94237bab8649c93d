"""Rates over many craft of known steering laws: what is found of the truth, and how far numbers and heading hold.

HELMBENCH_CRAFT_DRAWS craft are drawn, 60 unless said, on all cores (HELMBENCH_CRAFT_JOBS processes).
"""

import os
from typing import NamedTuple

import numpy as np
from joblib import Parallel, delayed

from helmbench.diagnosis.craft.build import build

from ...simulators.craft import LAWS, draw, sailed

DRAWS = int(os.environ.get("HELMBENCH_CRAFT_DRAWS", "60"))
JOBS = int(os.environ.get("HELMBENCH_CRAFT_JOBS", "-1"))
EXTRAS = ((), ("offset",), ("delay",), ("quadratic",), ("offset", "delay"))
FAMILY = {"flow": "rudder-in-flow", "race": "rudder-in-race", "thruster": "thruster-in-flow"}
RUNGS = {"delay": {"delay", "second_order"}, "quadratic": {"quadratic_damping", "cubic_damping"}}
TOLERANCE = 0.07
"""What a rate over 60 draws may fall short by without a change of the ladder: about two standard errors."""


class CraftRun(NamedTuple):
    """Of one draw: whether the law is right, rungs found and wanted, whether none is extra, share of held-out heading
    errors inside the band, and whether the intervals of the numbers hold the truth (only where the structure is right).
    """

    law: bool
    hits: int
    wanted: int
    clean: bool
    inside: float
    covered: tuple[bool, ...]


def truth(craft):
    """Number of the model -> its true value."""
    unit = craft.gain / craft.time / craft.length**2
    own = {
        "flow": {"distance_constant": craft.time * craft.length, "curvature_gain": craft.gain / craft.length},
        "race": {
            "a1": -1.0 / (craft.time * craft.length),
            "b2": craft.share * unit,
            "bn": (1.0 - craft.share) * craft.speed**2 * unit / 100.0,
        },
        "thruster": {"a": -craft.still, "a1": -1.0 / (craft.time * craft.length), "b": craft.speed**2 * unit},
    }
    more = {"rudder_offset": craft.offset, "rudder_delay": craft.delay, "added_Nr_absr": -craft.quadratic}
    return own[craft.law] | more


def drawn(k, seed):
    """The outcome of draw k."""
    rng = np.random.default_rng([seed, k])
    law, extras = LAWS[k % 3], EXTRAS[(k // 3) % len(EXTRAS)]
    craft = draw(rng, law, *extras)
    records = [sailed(rng, craft, f"run {i}") for i in range(4)]
    found = build(records[:3], records[3:])
    family = found.model.family.split("+")
    taken = {s.id for s in found.steps[1:]} - {told.id for told in found.laws}
    kept = {"rate_limit" if n == "rudder_rate_limit" else "delay" for n in found.model.instruments}
    kept |= {"quadratic_damping"} if any("yaw_damping" in part for part in family) else set()
    kept |= {"second_order"} if "second_order_lead" in family else set()
    expected = [RUNGS[extra] for extra in extras if extra in RUNGS]
    hits, right = sum(bool(kept & rungs) for rungs in expected), family[0] == FAMILY[law]
    clean = not taken - set().union(*expected)
    known = truth(craft)
    told = [n.low <= known[n.name] <= n.high for n in found.numbers if known.get(n.name)]
    print(law, extras, family[0], sorted(taken), found.verdict, round(found.inside, 2), round(found.wall_s, 1))
    exact = right and clean and hits == len(expected)
    return CraftRun(right, hits, len(expected), clean, found.inside, tuple(told) if exact else ())


def test_laws_rungs_intervals_and_bands_of_craft(seed):
    found = Parallel(n_jobs=JOBS, backend="multiprocessing")(delayed(drawn)(k, seed) for k in range(DRAWS))
    laws, clean = sum(f.law for f in found), sum(f.clean for f in found)
    hits, wanted = sum(f.hits for f in found), sum(f.wanted for f in found)
    inside, covered = np.nanmean([f.inside for f in found]), np.mean([c for f in found for c in f.covered])
    print(f"law {laws}, rungs {hits} of {wanted}, no extra rung {clean} of {DRAWS}")
    print(f"heading inside {inside:.2f}, truths inside their intervals {covered:.2f}")
    assert laws >= (0.9 - TOLERANCE) * DRAWS
    assert hits >= (0.85 - TOLERANCE) * wanted
    assert clean >= (0.9 - TOLERANCE) * DRAWS
    assert 0.55 - TOLERANCE <= inside <= 0.8 + TOLERANCE
    assert covered >= 0.85 - TOLERANCE
