"""How often a number that is wrong in one regime only is located, over draws of the regime and of the noise."""

from helmbench.bench.faults import Effect
from helmbench.bench.kinds.diagnosis.judge import regime_scores

from ...diagnosis.test_regimes import diagnosed, stated

DRAWS, LOCATED = 10, 7
"""Draws, and how many of them have to be located: of ten that were tried nine were."""
SIZED = 8
"""How many of them have to be located with their size: of eleven that were tried ten were; in the other a fault of the
steering gear took half of the size."""


def test_a_wake_that_is_wrong_in_turns_is_mostly_located(rng):
    effect, found = Effect("wake_loss", {"loss": 0.45, "drift": 0.1}), []
    for _ in range(DRAWS):
        case, outcome = diagnosed("kvlcc2-l7", effect, rng, duration_s=100.0, dt_s=0.25)
        found.append(regime_scores(outcome, case)["regime_f1"])
    print(found)
    assert sum(score > 0.8 for score in found) >= LOCATED


def test_a_rudder_that_loses_force_beyond_any_angle_is_mostly_located_with_its_size(rng):
    right = []
    for _ in range(DRAWS):
        angle = float(rng.uniform(0.19, 0.28))
        _, outcome = diagnosed("cargo", Effect("rudder_force_loss", {"loss": 0.2, "angle": angle}), rng)
        finding, regime = stated(outcome)
        right.append(abs(regime["threshold"] - angle) < 0.06 and abs(finding.sizes[0].value + 0.2) < 0.06)
    print(right)
    assert sum(right) >= SIZED
