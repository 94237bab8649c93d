"""How large errors of a clock may be by the roughness of the samples."""

import numpy as np

from helmbench.diagnosis.causes.noise import LARGEST_SHARE, largest_clock_error
from helmbench.diagnosis.causes.registry import terms_for
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve

from ...expectations.injections import injected


def test_clock_errors_are_bounded_by_the_roughness_of_the_samples(rng):
    smooth = injected("response-1", (), rng, train=("zigzag:20/20",), held_out=("zigzag:20/20",)).train[0]
    step = float(np.median(np.diff(smooth.time_s)))
    error = 0.4 * step * rng.standard_normal(smooth.n)
    taken = np.clip(smooth.time_s + error, smooth.time_s[0], smooth.time_s[-1])
    late = {name: np.interp(taken, smooth.time_s, smooth.column(name)) for name in ("heading_rad", "yaw_rate_rad_s")}
    model = resolve("response-1")
    calm, rough = (estimator(model, [r], terms=terms_for(model)) for r in (smooth, smooth.with_channels(**late)))
    print(step, largest_clock_error(calm), largest_clock_error(rough))
    assert 0.4 * step < largest_clock_error(rough) <= LARGEST_SHARE * step * (1.0 + 1e-9)
    assert largest_clock_error(calm) < largest_clock_error(rough)
