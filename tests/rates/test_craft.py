"""Rates over many craft of known steering laws: what is found of the truth, and how far the heading band holds."""

import os

import numpy as np

from helmbench.diagnosis.craft.build import build

from ..craft_simulator import LAWS, draw, sailed

DRAWS = int(os.environ.get("HELMBENCH_CRAFT_DRAWS", "60"))
EXTRAS = ((), ("offset",), ("delay",), ("quadratic",), ("offset", "delay"))
FAMILY = {"flow": "rudder-in-flow", "race": "rudder-in-race", "thruster": "thruster-in-flow"}
RUNGS = {"delay": {"delay", "second_order"}, "quadratic": {"quadratic_damping", "cubic_damping"}}
TOLERANCE = 0.07
"""What a rate over 60 draws may fall short by without a change of the ladder: about two standard errors."""


def test_laws_rungs_and_bands_of_craft(rng):
    laws = hits = wanted = clean = 0
    inside = []
    for k in range(DRAWS):
        law, extras = LAWS[k % 3], EXTRAS[(k // 3) % len(EXTRAS)]
        craft = draw(rng, law, *extras)
        records = [sailed(rng, craft, f"run {i}") for i in range(4)]
        found = build(records[:3], records[3:])
        family = found.model.family.split("+")
        taken = {s.id for s in found.steps[1:]} - {law.id for law in found.laws}
        kept = {"rate_limit" if n == "rudder_rate_limit" else "delay" for n in found.model.instruments}
        kept |= {"quadratic_damping"} if any("yaw_damping" in part for part in family) else set()
        kept |= {"second_order"} if "second_order_lead" in family else set()
        expected = [RUNGS[extra] for extra in extras if extra in RUNGS]
        laws += family[0] == FAMILY[law]
        hits += sum(bool(kept & rungs) for rungs in expected)
        wanted += len(expected)
        clean += not (taken - set().union(*expected))
        inside += [] if np.isnan(found.inside) else [found.inside]
        print(law, extras, family[0], sorted(taken), found.verdict, round(found.inside, 2), round(found.wall_s, 1))
    print(f"law {laws}, rungs {hits} of {wanted}, no extra rung {clean} of {DRAWS}, inside {np.mean(inside):.2f}")
    assert laws >= (0.9 - TOLERANCE) * DRAWS
    assert hits >= (0.85 - TOLERANCE) * wanted
    assert clean >= (0.9 - TOLERANCE) * DRAWS
    assert 0.55 - TOLERANCE <= np.mean(inside) <= 0.8 + TOLERANCE
