"""Intervals of sizes: never narrower than what the records, or the effect's description, can tell."""

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.result import NORMAL_90
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.generator import Case as Generated
from helmbench.diagnosis.causes.base import DESCRIBED
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.noise_fit import fit_noise
from helmbench.models.model import resolve


def test_a_clocks_error_is_drawn_once_a_sample(rng):
    """Heading, yaw rate and positions of a sample are late together: their number does not sharpen the interval."""
    case = inject(FaultCase("mariner", ("clock_jitter",), "large", duration_s=240.0, dt_s=1.0), rng)
    est = estimator(resolve("mariner"), case.train)
    s = est.with_entries(est.start(), {"clock_jitter": case.truth[0]["parameters"]["sd"]})
    s, _ = fit_noise(est, s, 6)
    (size,) = cause_of("clock_jitter").sizes(est, s, (), np.zeros((0, 0)), rng)
    samples = est.edges[-1]
    print(case.truth, size, samples)
    assert np.log(size.high / size.value) > 0.9 * NORMAL_90 / np.sqrt(2.0 * samples)


@pytest.mark.parametrize("name", ["rudder_offset", "constant_force", "current"])
def test_no_size_is_stated_better_than_its_effect_is_described(name, rng):
    est = estimator(resolve("mariner"), [generate(Generated("mariner", "zigzag:20/20", "low", seed=1))])
    cause = cause_of(name)
    variant = bank_of(est)[0][cause][-1]
    s = est.start()
    for p in variant:
        s = est.at(s, p, 0.3)
    k = len(variant)
    for size in cause.sizes(est, s, variant, np.zeros((k, k)), rng):
        about = 1.0 if size.unit == "rad" and name == "current" else abs(size.value)
        assert 0.5 * (size.high - size.low) == pytest.approx(NORMAL_90 * DESCRIBED * about, rel=0.15)


# ---- What the causes of the bank change in the model.


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo"])
def test_the_shift_of_a_published_parameter_moves_it_alone(vessel):
    model = resolve(vessel)
    est = estimator(model, [generate(Case(vessel, "zigzag:20/20", "low", seed=1))])
    shift_of = cause_of("coefficient_shift")
    shifts = {shift_of.details(est, v)["coefficient"]: v[0] for v in bank_of(est)[0][shift_of]}
    before = dict(zip(model.parameter_names, model.to_parameters(model.coefficients), strict=True))
    assert set(shifts) == {name for name, value in before.items() if value != 0.0} - {"K"}
    for name, shift in shifts.items():
        moved = est.at(est.start(), shift, 0.1).vectors[0]
        after = model.to_parameters(np.array([moved[est.index[c]] for c in model.coordinates]))
        ratio = {n: value / before[n] for n, value in zip(model.parameter_names, after, strict=True) if before[n]}
        assert ratio == pytest.approx({n: 1.1 if n == name else 1.0 for n in ratio}, rel=1e-9)
