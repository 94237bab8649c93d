"""The minimum of a function of one number: the same steps as SciPy's, to the last bit."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from helmbench.estimation.scalar_minimum import bounded_minimum

SHAPES = {
    "parabola": lambda x, c: (x - c) ** 2,
    "kink": lambda x, c: abs(x - c),
    "waves": lambda x, c: np.sin(5.0 * x) + 0.1 * (x - c) ** 2,
    "flat": lambda x, c: 1.0,
    "steep": lambda x, c: np.exp(c * x) - x,
    "wall": lambda x, c: np.inf if x > c else -x,
}


@pytest.mark.parametrize("shape", SHAPES)
def test_the_steps_are_those_of_scipy(shape):
    seed = int(np.random.SeedSequence().generate_state(1)[0])
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    for _ in range(50):
        low, width, centre = rng.uniform(-3.0, 3.0), rng.exponential(2.0), rng.uniform(-3.0, 3.0)
        accuracy, most = 10.0 ** rng.uniform(-8.0, -1.0), int(rng.integers(2, 40))
        places = [[], []]

        def followed(kept, centre=centre):
            return lambda x: kept.append(float(x)) or SHAPES[shape](x, centre)

        with np.errstate(all="ignore"):
            ours = bounded_minimum(followed(places[0]), low, low + width, accuracy, most)
            theirs = minimize_scalar(
                followed(places[1]), bounds=(low, low + width), options={"xatol": accuracy, "maxiter": most}
            )
        assert places[0] == places[1]
        assert (ours.x, ours.value) == (theirs.x, theirs.fun)


def test_a_minimum_inside_and_one_at_a_bound():
    assert bounded_minimum(lambda x: (x - 0.3) ** 2, -1.0, 2.0, 1e-8).x == pytest.approx(0.3, abs=1e-7)
    assert bounded_minimum(lambda x: x, -1.0, 2.0, 1e-8).x == pytest.approx(-1.0, abs=1e-6)
