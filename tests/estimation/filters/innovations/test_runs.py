"""Runs that are kept are those that would be made again, and no others."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.estimation.filters.innovations.estimator import Recent, content_of, estimator


@pytest.fixture
def est(suite):
    model, records = suite("mariner", "low")
    return estimator(model, [record.thinned(4) for record in records], threads=1)


def settings(est):
    """Settings that differ from the first one in one thing each."""
    s = est.start()
    yield s
    yield est.with_entries(s, {"rudder_offset": 0.01})
    yield replace(s, noise=replace(s.noise, sensor_sd=2.0 * s.noise.sensor_sd))
    yield replace(s, noise=replace(s.noise, force_sd=np.full(3, 1e-4)))
    yield replace(s, noise=replace(s.noise, force_sd=np.full(3, 1e-4), correlation_time_s=3.0))
    yield replace(s, added=tuple(np.full((d.time.size, 9), 1e-4) for d in est.segments))


def test_each_setting_has_its_own_run(est):
    found = [est.run(s, 0).e for s in settings(est)]
    for s, e in zip(settings(est), found, strict=True):
        np.testing.assert_array_equal(replace(est).run(s, 0).e, e)
        assert sum(np.array_equal(e, other) for other in found) == 1


def test_a_setting_that_comes_again_is_not_run_again(est, monkeypatch):
    s = est.start()
    run, trace = est.traced(s, 0)
    monkeypatch.setattr(f"{estimator.__module__}.run_of", None)  # what a further run would need
    assert est.run(est.start(), 0) is run
    assert est.traced(replace(s, vectors=s.vectors.copy()), 0) == (run, trace)
    with pytest.raises(TypeError):
        est.run(s, 0, free=50)


def test_a_run_without_trace_is_made_again_where_one_is_wanted(est):
    s = est.start()
    plain = est.run(s, 0)
    run, trace = est.traced(s, 0)
    np.testing.assert_array_equal(run.e, plain.e)
    assert np.count_nonzero(trace.roots) == np.isfinite(est.segments[0].measured[:, est.channels]).sum()


def test_the_run_that_was_not_asked_for_longest_is_let_go():
    kept = Recent(2)
    for key in "ab":
        kept.put((key,), (key, None))
    assert kept.get(("a",), False) == ("a", None)
    kept.put(("c",), ("c", None))
    assert [kept.get((key,), False) is not None for key in "abc"] == [True, False, True]


def test_the_time_of_a_rudder_fault_counts_where_there_is_one(est):
    """Of no size it changes no run; of a size it does."""

    def content(size, time):
        changed = est.with_entries(est.start(), {"rudder_fault": size, "rudder_fault_time": time})
        return content_of(changed, 0, est.index)

    assert content(0.0, 10.0) == content(0.0, 20.0)
    assert content(0.1, 10.0) != content(0.1, 20.0)
