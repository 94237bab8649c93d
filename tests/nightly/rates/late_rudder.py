"""A rudder that acts late, beside a Mariner whose numbers are all wrong by about 10 %."""

import numpy as np

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.causes.missing_terms import MissingTerm
from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve

from ...expectations.injections import Expectation

DELAY_S = 2.5
TERMS = {name for name, cause in causes().items() if isinstance(cause, MissingTerm)}
"""Wrong numbers may look like a lacking term."""


def delay_beside_wrong_numbers_is_named_and_no_other(rng: np.random.Generator) -> bool:
    """Within 2.5 halves of its 90 % interval, 4.1 standard errors, which are less than 2 s."""
    ship = resolve("mariner")
    model = ship.with_coefficients(ship.coefficients * (1.0 + 0.1 * rng.standard_normal(ship.coefficients.size)))
    late = Effect("rudder_delay", {"tau": DELAY_S})
    made = inject(FaultCase("mariner", effects=(late,)), rng)
    sizes = {f.cause: f.sizes for f in diagnose(model, made.train).causes}
    print(sizes)
    if {*sizes} - {"base_coefficients", *TERMS} != {"rudder_delay"}:
        return False
    (delay,) = sizes["rudder_delay"]
    half = (delay.high - delay.low) / 2.0
    return abs(delay.value - DELAY_S) < 2.5 * half < 2.0


LATE_RUDDER = Expectation(delay_beside_wrong_numbers_is_named_and_no_other, 0.65)
"""24 of 33 draws.  In the others its interval is wider, the neutral rudder angle is named beside it, or numbers of the
hull in its place."""
