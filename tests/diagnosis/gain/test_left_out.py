"""Errors of left-out training records: a cause stays by what it predicts there."""

from itertools import chain

import numpy as np
import pytest

from helmbench.diagnosis.by_residuals import selected
from helmbench.diagnosis.candidate import Candidate
from helmbench.diagnosis.causes.clock_jitter import LARGEST_SHARE, largest
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import terms_for
from helmbench.diagnosis.gain.left_out import best_ratio, left_out_errors, motions, worst_ratio
from helmbench.diagnosis.gain.measured import base_setting, predicting
from helmbench.diagnosis.options import Options
from helmbench.diagnosis.prepared import corrected_records
from helmbench.diagnosis.starting import starting_state
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.settings import Parameter
from helmbench.models.model import resolve

from ...expectations.injections import injected


@pytest.fixture(params=[("zigzag:20/20",), ("zigzag:20/20", "turn:20")], ids=["one record", "two records"])
def shown(request, rng):
    """An estimator of records of a ship with a rudder offset, and the offset (rad)."""
    case = injected("response-1", ("rudder_offset",), rng, train=request.param, held_out=("zigzag:20/20",))
    model = resolve("response-1")
    est = estimator(model, case.train, terms=terms_for(model))
    return est, starting_state(est, Options(coefficient_sd=0.0))[0]


def offset(est) -> Parameter:
    return Parameter("delta0", "rad", ((est.index["rudder_offset"], 1.0),), scale=1e-4)


def test_the_true_cause_predicts_what_was_left_out_and_its_opposite_does_not(shown, rng):
    est, state = shown
    own = offset(est)
    fitted, _ = state.refit(state.setting, (own,), 6)
    value = est.value(fitted, own)
    base = left_out_errors(est, state.setting, (), False, False)
    true = left_out_errors(est, fitted, (own,), False, False)
    wrong = left_out_errors(est, est.at(fitted, own, -value), (), False, False)
    motion = motions(est)
    print(np.rad2deg(value), worst_ratio(base, true, motion, rng), worst_ratio(base, wrong, motion, rng))
    assert worst_ratio(base, true, motion, rng) == 1.0
    assert worst_ratio(base, wrong, motion, rng) > 1.3
    assert best_ratio(base, true, rng) < 0.8 and best_ratio(base, base, rng) == 1.0
    turned = 1  # yaw rate
    assert true[turned][:, 0].sum() < base[turned][:, 0].sum()


def test_errors_that_grow_by_little_of_the_motion_are_not_worse(shown, rng):
    est, state = shown
    base = left_out_errors(est, state.setting, (), False, False)
    motion = motions(est)
    grown = {c: blocks * [4.0, 1.0] for c, blocks in base.items()}
    large = {c: float(np.sqrt(3.0 * blocks[:, 0].sum() / blocks[:, 1].sum())) / motion[c] for c, blocks in base.items()}
    print(large)
    assert worst_ratio(base, grown, motion, rng) == 2.0
    assert worst_ratio(base, grown, {c: 101.0 * large[c] * m for c, m in motion.items()}, rng) == 1.0


def two_causes(rng):
    """Three records of a ship with a rudder offset, both it and a scale of the yaw rate accepted."""
    train = ("zigzag:20/20", "zigzag:10/10", "zigzag:20/10")
    case = injected("response-1", ("rudder_offset",), rng, train=train, held_out=("zigzag:20/20",))
    model = resolve("response-1")
    est = estimator(model, case.train, terms=terms_for(model))
    state = starting_state(est, Options(coefficient_sd=0.0))[0]
    chosen = [cause_of(name) for name in ("rudder_offset", "yaw_rate_scale")]
    variants = [state.bank[cause][0] for cause in chosen]
    s, now = state.refit(state.setting, tuple(chain(*variants)), 6)
    return state.at(s, now, [Candidate(c, v, 0.0, 0.0, s, now) for c, v in zip(chosen, variants, strict=True)])


def test_where_each_cause_has_to_gain_a_needless_one_is_left_out(rng):
    idle = []
    for _ in range(4):
        state = two_causes(rng)
        found, all_kept = predicting(state, Options(), gaining=True), predicting(state, Options())
        print([cause.id for cause in found.idle], [cause.id for cause in found.failing])
        assert "rudder_offset" in {cause.id for cause in found.state.causes}
        assert all_kept.idle == ()
        idle += [cause.id for cause in found.idle]
    assert idle.count("yaw_rate_scale") >= 2


@pytest.mark.nightly
def test_what_belongs_to_a_record_is_known_from_its_first_part_when_the_rest_is_left_out(rng):
    """A current of every record: without any of its own samples it could be anything."""
    ratios = []
    for _ in range(4):
        case = injected("mariner", ("current",), rng)
        model, options = resolve("mariner"), Options(coefficient_sd=0.0, only=("current",)).checked(resolve("mariner"))
        given = corrected_records(model, case.train, (), options)
        state = selected(model, given, options).state
        found = predicting(state, options)
        base = left_out_errors(state.est, base_setting(state, options), (), False, True)
        after = left_out_errors(state.est, state.setting, state.parameters, False, True)
        print(case.truth, [cause.id for cause in found.failing], best_ratio(base, after, rng))
        assert [cause.id for cause in state.causes] == ["current"] and not found.failing
        ratios.append(best_ratio(base, after, rng))
    assert max(ratios) < 0.8


def test_every_sample_after_the_start_is_left_out_once(shown):
    est, state = shown
    blocks = left_out_errors(est, state.setting, (), False, False)
    for c, found in blocks.items():
        known = sum(int(np.isfinite(d.measured[:, c]).sum()) for d in est.segments)
        assert 0.75 * known < found[:, 1].sum() < known


def test_clock_errors_are_bounded_by_the_roughness_of_the_samples(rng):
    smooth = injected("response-1", (), rng, train=("zigzag:20/20",), held_out=("zigzag:20/20",)).train[0]
    step = float(np.median(np.diff(smooth.time_s)))
    error = 0.4 * step * rng.standard_normal(smooth.n)
    taken = np.clip(smooth.time_s + error, smooth.time_s[0], smooth.time_s[-1])
    late = {name: np.interp(taken, smooth.time_s, smooth.column(name)) for name in ("heading_rad", "yaw_rate_rad_s")}
    model = resolve("response-1")
    calm, rough = (estimator(model, [r], terms=terms_for(model)) for r in (smooth, smooth.with_channels(**late)))
    print(step, largest(calm), largest(rough))
    assert 0.4 * step < largest(rough) <= LARGEST_SHARE * step * (1.0 + 1e-9)
    assert largest(calm) < largest(rough)
