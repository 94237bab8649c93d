"""Intervals of sizes: never narrower than what the records, or the effect's description, can tell."""

import numpy as np
import pytest

from helmbench.bench.planting import Case, plant
from helmbench.datasets.generator import Case as Generated
from helmbench.datasets.generator import generate
from helmbench.diagnosis import causes
from helmbench.diagnosis.sizes import DESCRIBED, NORMAL_90, sizes_of
from helmbench.methods.innovations.estimator import Estimator, Setting
from helmbench.models.model import resolve


def test_a_clocks_error_is_drawn_once_a_sample(rng):
    """Heading, yaw rate and positions of a sample are late together: their number does not sharpen the interval."""
    case = plant(Case("mariner", ("clock_jitter",), "large", duration_s=240.0, dt_s=1.0), rng)
    est = Estimator(resolve("mariner"), case.train)
    s = est.start()
    p = s.p.copy()
    p[:, est.index["clock"]] = case.truth[0]["parameters"]["sd"]
    s, _ = est.fit_noise(Setting(p, s.noise), 6)
    (size,) = sizes_of(est, s, "clock_jitter", (), np.zeros((0, 0)), rng)
    samples = sum(d.time.size for d in est.data)
    print(case.truth, size, samples)
    assert np.log(size.high / size.value) > 0.9 * NORMAL_90 / np.sqrt(2.0 * samples)


@pytest.mark.parametrize("cause", ["rudder_offset", "constant_force", "current"])
def test_no_size_is_told_better_than_its_effect_is_described(cause, rng):
    est = Estimator(resolve("mariner"), [generate(Generated("mariner", "zigzag:20/20", "low", seed=1))])
    variant = causes.testable(est)[0][cause][-1]
    s = est.start()
    for p in variant:
        s = est.at(s, p, 0.3)
    k = len(variant)
    for size in sizes_of(est, s, cause, variant, np.zeros((k, k)), rng):
        about = 1.0 if size.unit == "rad" and cause == "current" else abs(size.value)
        assert 0.5 * (size.high - size.low) == pytest.approx(NORMAL_90 * DESCRIBED * about, rel=0.15)
