"""How often a number that is wrong in turns only is located, over draws of the noise."""

from helmbench.bench.faults import Effect
from helmbench.bench.kinds.diagnosis.localisation import regime_scores

from ...diagnosis.test_regimes import diagnosed

DRAWS, LOCATED = 10, 7
"""Draws, and how many of them have to be located: of ten that were tried nine were."""


def test_a_wake_that_is_wrong_in_turns_is_mostly_located(rng):
    effect, found = Effect("wake_loss", {"loss": 0.45, "drift": 0.1}), []
    for _ in range(DRAWS):
        case, outcome = diagnosed("kvlcc2-l7", effect, rng, duration_s=100.0, dt_s=0.25)
        found.append(regime_scores(outcome, case)["regime_f1"])
    print(found)
    assert sum(score > 0.8 for score in found) >= LOCATED
