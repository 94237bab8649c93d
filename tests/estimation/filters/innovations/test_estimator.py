"""Likelihood, derivatives and noise fit of the innovations estimator."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.sensors import NOISE
from helmbench.datasets.spikes import without_spikes, without_spikes_in_time
from helmbench.estimation.filters.innovations import noise_fit
from helmbench.estimation.filters.innovations.derivatives import columns, responses, tangent, traces
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.noise_fit import QUANTUM, fit_noise, fit_noise_from_starts
from helmbench.estimation.filters.innovations.settings import Parameter
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve
from helmbench.models.simulate import inputs_of, simulate

BEGINNING_S = 30.0
SENSORS = ("heading", "yaw_rate", "surge", "sway", "north", "east")


def _records(vessel, noise="low", seed=5, count=2, **options):
    model = resolve(vessel)
    texts = model.suite["train"][:count]
    return model, [generate(Case(vessel, text, noise, seed=seed, **options)) for text in texts]


def _noisy(s, **changes):
    return replace(s, noise=replace(s.noise, **changes))


def _gusty(est, amount=2e-5):
    return _noisy(est.start(), force_sd=np.full(est.n_forces, amount))


@pytest.fixture(scope="module", params=["mariner", "response-2"])
def short(request):
    model, records = _records(request.param, duration_s=150.0)
    est = estimator(model, records)
    return est, _gusty(est)


def _difference(est, step, h):
    """Central difference of the innovations (N*6,), extrapolated from two steps."""

    def central(h):
        return (est.evaluate(step(h)).e - est.evaluate(step(-h)).e).ravel() / (2.0 * h)

    return (4.0 * central(0.5 * h) - central(h)) / 3.0


def _apart(found, wanted):
    return np.linalg.norm(found - wanted) / np.linalg.norm(wanted)


ENTRIES = {
    "rudder_offset": 1e-4,
    "rudder_effectiveness": 1e-3,
    "rudder_delay": 1e-3,
    "yaw_rate_bias": 1e-6,
    "yaw_rate_scale": 1e-4,
    "yaw_rate_delay": 1e-3,
    "heading_delay": 1e-3,
}
OF_SHIPS = {
    "current_towards_north": 1e-3,
    "wind_towards_east": 1e-2,
    "wave_drift_north": 1.0,
    "constant_Y": 10.0,
    "surge_scale": 1e-4,
    "sway_bias": 1e-5,
    "axis_misalignment": 1e-4,
    "surge_delay": 1e-3,
    "heading_bias": 1e-5,
}


@pytest.mark.parametrize("vessel", ["mariner", "response-2"])
def test_derivatives_by_entries_of_the_vector(vessel):
    """What the change of the gains adds is left out: little without random forces."""
    model, records = _records(vessel, duration_s=150.0)
    est = estimator(model, records).with_corners(0.0)
    entries = ENTRIES | (OF_SHIPS if model.is_3dof else {})
    s = est.with_entries(est.start(), {name: 0.33 for name in entries if name.endswith("_delay")})
    if model.is_3dof:
        s = est.with_entries(s, {"wave_drift_north": 2e4, "wave_drift_east": 1e4})
    found = tangent(est, s, [est.index[name] for name in entries])
    for (name, h), column in zip(entries.items(), found, strict=True):
        value = float(s.vectors[0, est.index[name]])
        own = _difference(est, lambda v, n=name, x=value: est.with_entries(s, {n: x + v}), h)
        assert _apart(column, own) < 0.1, name


@pytest.mark.parametrize(("vessel", "name"), [("mariner", "north_bias"), ("response-2", "heading_bias")])
def test_what_a_first_state_takes_up_shows_nowhere(vessel, name):
    """Nothing tells a shift of all positions, or of all headings where no track is modelled."""
    model, records = _records(vessel, duration_s=150.0)
    est = estimator(model, records)
    scale = np.linalg.norm(tangent(est, est.start(), [est.index["yaw_rate_bias"]]))
    assert np.linalg.norm(tangent(est, est.start(), [est.index[name]])) < 1e-6 * scale


def test_derivatives_by_coefficients(short):
    """All coefficients in one run; under random forces the change of the gains is larger."""
    est, s = short
    p = min(len(est.model.coordinates), 12)
    for setting, most in ((est.start(), 0.02), (s, 0.1)):
        found = tangent(est, setting, range(p))
        size = 1e-4 * np.maximum(np.abs(est.model.coefficients), 1e-6)

        def moved(h, j, at=setting):
            return est.moved(at, Parameter(str(j), "", ((j, 1.0),)), h)

        own = [_difference(est, lambda h, j=j: moved(h, j), size[j]) for j in range(p)]
        assert np.median([_apart(a, b) for a, b in zip(found, own, strict=True)]) < most


def test_coefficients_of_a_linear_model_are_exact_but_for_the_midpoint_rule():
    model, records = _records("remus-kt", count=1)
    est = estimator(model, records)
    s = est.start()
    for j, found in enumerate(tangent(est, s, range(2))):
        own = _difference(est, lambda h, j=j: est.moved(s, Parameter(str(j), "", ((j, 1.0),)), h), 1e-5)
        assert _apart(found, own) < 0.03


def test_columns_sum_slots_and_keep_to_their_record(short):
    est, s = short
    index = est.index
    two = Parameter("two", "", ((index["rudder_offset"], 0.5), (index["yaw_rate_bias"], 2.0)), scale=2e-5)
    second = Parameter("rate bias", "rad/s", ((index["yaw_rate_bias"], 1.0),), record=1)
    square = Parameter("law", "1", ((index["rudder_offset"], 1.0),), law=lambda v: np.array([v**2]), scale=1e-5)
    there = est.at(s, square, 0.1)
    step = {index["rudder_offset"]: 1e-5}
    single = tangent(est, s, [index["rudder_offset"], index["yaw_rate_bias"]], step)
    found = columns(est, s, [two, second])
    assert found[0] == pytest.approx(0.5 * single[0] + 2.0 * single[1])
    edge = est.edges[1] * 6
    assert not found[1][:edge].any() and np.array_equal(found[1][edge:], single[1][edge:])
    own = tangent(est, there, [index["rudder_offset"]])[0]
    assert columns(est, there, [square])[0] == pytest.approx(0.2 * own, rel=1e-3)


def test_responses_are_derivatives_by_added_series(short, rng):
    est, s = short
    nf, sizes = est.n_forces, [d.time.size for d in est.segments]
    axes = [nf - 1, nf, nf + 1]  # a force, a heading shift, a rate shift
    forcing = [[np.cumsum(rng.normal(size=n)) / np.sqrt(n) for n in sizes] for _ in axes]
    found = responses(est, traces(est, s), axes, forcing)
    for axis, series, response, h in zip(axes, forcing, found, (1e-5, 1e-5, 1e-6), strict=True):

        def added(v, axis=axis, series=series):
            arrays = []
            for own in series:
                arrays.append(np.zeros((own.size, nf + 6)))
                arrays[-1][:, axis] = v * own
            return replace(s, added=tuple(arrays))

        own = (est.evaluate(added(h)).e - est.evaluate(added(-h)).e).ravel() / (2.0 * h)
        assert _apart(response, own) < 0.03


@pytest.mark.parametrize("waves", [False, True])
def test_derivatives_by_the_noise_are_those_of_the_likelihood(short, waves):
    """Exact but for the model's slopes, which the noise moves a little by moving the states, and for the variance of
    the first state, which is soon forgotten."""
    est, s = short
    if waves:
        s = est.with_entries(s, {"wave_rms": 0.005})
    nf, (by_e, by_log_s) = est.n_forces, noise_fit.by_noise(est, noise_fit._stored(est, s))
    for j in [*range(nf + 1), *(nf + 1 + np.flatnonzero(est.channels)).tolist()]:

        def moved(h, j=j):
            noise = s.noise
            if j > nf:
                return est.evaluate(_noisy(s, sensor_sd=noise.sensor_sd * np.exp(h * (np.arange(6) == j - nf - 1))))
            if j == nf:
                return est.evaluate(_noisy(s, correlation_time_s=noise.correlation_time_s * np.exp(h)))
            sd = noise.force_sd.copy()
            sd[j] = np.sqrt(sd[j] ** 2 + h * QUANTUM**2)
            return est.evaluate(_noisy(s, force_sd=sd))

        h = 1e-3 if j >= nf else 1e-3 * (s.noise.force_sd[j] / QUANTUM) ** 2
        up, down = moved(h), moved(-h)
        later = np.repeat(est.joined(lambda d, j=j: d.time > (BEGINNING_S if j > nf else -1.0)), 6)
        assert _apart(by_e[j, later], (up.e - down.e).ravel()[later] / (2.0 * h)) < 0.02
        assert _apart(by_log_s[j, later], (up.log_s - down.log_s).ravel()[later] / (2.0 * h)) < 0.02


@pytest.mark.parametrize("vessel", ["mariner", "response-2"])
def test_sensor_noise_is_found(vessel, seed):
    """Fisher scoring from twice the truth comes to the true standard deviations within their standard errors."""
    model, records = _records(vessel, "medium", seed % 2**31)
    est = estimator(model, records).with_corners(0.0)
    s = est.start()
    found, now = fit_noise(est, _noisy(s, sensor_sd=2.0 * s.noise.sensor_sd), 12)
    true = np.array([NOISE["medium"][name] for name in SENSORS])
    n = sum(r.n for r in records)
    used = est.channels
    assert np.abs(np.log(found.noise.sensor_sd / true)[used]).max() < 4.5 / np.sqrt(2.0 * n) + 0.01
    assert now.log_likelihood >= est.evaluate(s).log_likelihood - 0.1


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_noise_from_far_ends_at_the_optimum(short, factor):
    """Where a fit ends before its optimum depends on the processor; its steps are bounded, so a long way takes many."""
    est, s = short
    near = fit_noise_from_starts(est, s, s)[1].log_likelihood
    far = _noisy(s, sensor_sd=np.maximum(factor * s.noise.sensor_sd, est.floors))
    assert abs(fit_noise_from_starts(est, far, far)[1].log_likelihood - near) < 0.5


def test_turning_circles_do_not_raise_the_headings_floor():
    """Headings go round the compass: a compass of .1 deg is believed however far the ship has turned."""
    record = generate(Case("cargo", "turn:35", "low", seed=1, duration_s=1500.0))
    est = estimator(resolve("cargo"), [record])
    assert np.ptp(est.segments[0].measured[:, 0]) > 4.0 * np.pi
    assert est.floors[0] < np.deg2rad(0.05)


def test_a_stored_run_is_the_run(short):
    """Noise steps take the run that they differentiate for the one that they start from."""
    est, s = short
    assert all(np.array_equal(*pair) for pair in zip(noise_fit._stored(est, s).now, est.evaluate(s), strict=True))


def test_threads_change_nothing(short):
    est, s = short
    alone = replace(est, threads=1)
    assert np.array_equal(alone.evaluate(s).e, est.evaluate(s).e)
    assert fit_noise(alone, s, 3)[0].noise.equals(fit_noise(est, s, 3)[0].noise)


def test_missing_channels_count_as_gaps():
    model, records = _records("mariner", duration_s=150.0)
    nowhere = [r.with_channels(sway_m_s=np.full(r.n, np.nan), north_m=None, east_m=None) for r in records]
    absent = [r.with_channels(sway_m_s=None, north_m=None, east_m=None) for r in records]
    a, b = estimator(model, nowhere), estimator(model, absent)
    first, second = a.evaluate(a.start()), b.evaluate(b.start())
    assert np.array_equal(first.e, second.e) and np.isfinite(first.log_likelihood)
    assert not first.e[:, [3, 4, 5]].any() and first.e[:, :3].any(axis=0).all()


def test_positions_that_nothing_measures_do_not_matter():
    """Left out of the covariance, or measured without weight: the same."""
    model, records = _records("mariner", duration_s=150.0)
    without = estimator(model, [r.with_channels(north_m=None, east_m=None) for r in records])
    ignored = estimator(model, records)
    s, far = without.start(), ignored.start()
    far = _noisy(far, sensor_sd=np.where(np.arange(6) < 4, far.noise.sensor_sd, 1e9))
    first, second = without.evaluate(s), ignored.evaluate(far)
    assert first.e[:, :4] == pytest.approx(second.e[:, :4], abs=1e-6)
    assert first.log_s[:, :4] == pytest.approx(second.log_s[:, :4], abs=1e-6)


def test_gaps_do_not_matter(seed):
    """With a third of the samples lost the innovations that are left are still of unit variance."""
    model, records = _records("mariner", "low", seed % 2**31, 1)
    rng, record = np.random.default_rng(seed), records[0]
    holed = {}
    for name in ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m"):
        values = record.column(name).copy()
        values[rng.random(record.n) < 0.3] = np.nan
        values[100:140] = np.nan
        holed[name] = values
    est = estimator(model, [record.with_channels(**holed)]).with_corners(0.0)
    now = est.evaluate(_noisy(est.start(), sensor_sd=np.array([NOISE["low"][name] for name in SENSORS])))
    known = now.log_s != 0.0
    assert not now.e[100:140].any()
    late = np.arange(record.n) >= 20
    for c in range(6):
        e = now.e[known[:, c] & late, c]
        assert abs(np.mean(e**2) - 1.0) < 4.5 * np.sqrt(2.0 / e.size)


def test_gaps_in_the_propeller_series_are_bridged():
    model, records = _records("kvlcc2-l7", count=1, duration_s=20.0)
    turns = records[0].column("propeller_rps").copy()
    turns[10:20] = np.nan
    est = estimator(model, [records[0].with_channels(propeller_rps=turns)])
    assert np.isfinite(est.evaluate(est.start()).log_likelihood)
    with pytest.raises(CannotFit):
        estimator(model, [records[0].with_channels(propeller_rps=np.full(records[0].n, np.nan))])


def test_spikes_become_gaps(rng):
    clean = np.sin(0.05 * np.arange(400)) + 0.01 * rng.normal(size=400)
    spoilt = clean.copy()
    spoilt[[50, 200, 333]] += [0.5, -0.4, 1.0]
    found, count, _ = without_spikes(spoilt)
    assert count == 3 and np.flatnonzero(np.isnan(found)).tolist() == [50, 200, 333]
    assert np.array_equal(np.delete(found, [50, 200, 333]), np.delete(clean, [50, 200, 333]))


def test_spikes_beside_each_other_are_seen(rng):
    """Of one sample in twenty: at most one in eight escapes or is taken beside (3 records in 1000 give more)."""

    def check():
        clean = np.sin(0.05 * np.arange(1200)) + 0.01 * rng.normal(size=1200)
        true = rng.random(1200) < 0.05
        spikes = rng.choice([-1.0, 1.0], 1200) * rng.uniform(0.12, 0.3, 1200)
        taken = np.isnan(without_spikes(clean + np.where(true, spikes, 0.0))[0])
        most = 0.125 * true.sum()
        return (true & ~taken).sum() <= most and (taken & ~true).sum() <= most

    assert check() or check()


@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7", "patrol"])
def test_corners_of_a_motion_without_noise_are_no_spikes(vessel):
    record = generate(Case(vessel, "zigzag:20/20", "none", seed=1))
    channels = [
        record.heading_unwrapped(),
        *(record.column(n) for n in ("yaw_rate_rad_s", "surge_m_s") if record.has(n)),
    ]
    assert [without_spikes(values)[1] for values in channels] == [0] * len(channels)


@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7"])
def test_where_half_the_rows_are_missing_a_motion_has_no_spikes_but_gross_errors_are_seen(vessel, rng):
    """Of 40 gross errors at least 10 are seen (each with neighbours near enough: six in ten are), of the others 2."""
    record = generate(Case(vessel, "zigzag:20/20", "low", seed=int(rng.integers(100)), duration_s=300.0))
    seen, wrong = 0, 0
    for _ in range(10):
        kept = np.sort(rng.choice(record.n, record.n // 2, replace=False))
        time, rate = record.time_s[kept], record.column("yaw_rate_rad_s")[kept]
        wrong += without_spikes_in_time(rate, time)[1]
        gross = rng.choice(np.arange(5, kept.size - 5), 4, replace=False)
        rate[gross] += rng.choice([-1.0, 1.0], 4) * 0.5 * np.ptp(rate)
        seen += int(np.isnan(without_spikes_in_time(rate, time)[0][gross]).sum())
    assert seen >= 10 and wrong <= 2


def test_a_sample_is_cut_into_as_many_steps_as_its_innovations_need():
    """Slow sampling of a small ship: fewer than its own finest step asks, and no innovation tells the difference."""
    model, records = _records("kvlcc2-l7", count=1, duration_s=150.0, dt_s=0.5)
    est = estimator(model, records)
    finest = int(np.ceil(0.5 / model.max_step_s))
    assert est.shape.substeps < finest
    fine = replace(est)
    fine.__dict__["shape"] = est.shape._replace(substeps=4 * finest)
    found, wanted = est.evaluate(est.start()).e, fine.evaluate(est.start()).e
    assert np.all(np.abs(found - wanted) < 5e-3 * (1.0 + np.abs(wanted)))


def test_noise_is_fitted_from_every_start_where_forces_are_nearly_collinear(rng):
    """The two forces of a second-order response model do much the same; no start above the truth is a dead end."""
    model, records = _records("response-2", duration_s=150.0)
    est = estimator(model, records)
    best = noise_fit.fit_noise_from_starts(est, est.start(), est.start())[1].log_likelihood
    for _ in range(10):
        sd = QUANTUM * np.sqrt(10.0 ** rng.uniform(0.0, 1.5, 2))
        s = _noisy(est.start(), force_sd=sd, correlation_time_s=est.clock * 10.0 ** rng.uniform(0.0, 1.5))
        assert best - est.evaluate(s).log_likelihood > 100.0
        found = noise_fit.fit_noise(est, s, noise_fit.MOST_STEPS)[1].log_likelihood
        assert best - found < 1.0, (sd, s.noise.correlation_time_s)


def test_a_long_gap_cuts_a_record(seed):
    """Rows that a logger lost: each stretch has its own first state, and innovations stay of unit variance."""
    model, (record,) = _records("mariner", "low", seed % 2**31, 1)
    lost = (record.time_s > 200.0) & (record.time_s < 260.0)
    kept = {name: values[~lost] for name, values in record.channels.items()}
    holed = replace(record, time_s=record.time_s[~lost], channels=kept)
    est = estimator(model, [holed]).with_corners(0.0)
    assert [d.record for d in est.segments] == [0, 0] and est.n_records == 1
    assert est.segments[1].offset_s >= 260.0 and est.segments[1].time[0] == 0.0
    sd = np.array([NOISE["low"][name] for name in SENSORS])
    now = est.evaluate(_noisy(est.start(), sensor_sd=sd))
    for rows in (est.samples_of(0), est.samples_of(1)):
        e = now.e[rows][20:]
        assert np.abs(np.mean(e**2, axis=0) - 1.0).max() < 4.5 * np.sqrt(2.0 / len(e))


def test_a_fault_keeps_its_time_behind_a_gap():
    model, (record,) = _records("mariner", "low", 5, 1)
    whole = estimator(model, [record]).with_corners(0.0)
    lost = (record.time_s > 100.0) & (record.time_s < 130.0)
    kept = {name: values[~lost] for name, values in record.channels.items()}
    cut = estimator(model, [replace(record, time_s=record.time_s[~lost], channels=kept)], whole.unit).with_corners(0.0)
    late = {"rudder_fault": -0.5, "rudder_fault_time": 300.0}
    changes = []
    for est in (whole, cut):
        s = est.start()
        change = est.evaluate(est.with_entries(s, late)).e - est.evaluate(s).e
        rows = slice(est.edges[-2], est.edges[-1])
        time = est.segments[-1].time + est.segments[-1].offset_s
        changes.append(time[np.abs(change[rows]).max(axis=1) > 1e-6][0])
    assert changes[0] == pytest.approx(changes[1], abs=record.dt) and 299.0 < changes[0] < 302.0


def test_no_random_force_is_left_after_release():
    """The filter holds large gusts at release; from there on the run is a plain simulation."""
    est, free = estimator(*_records("mariner", "none", count=1, duration_s=200.0)), 40
    gusts = _noisy(est.start(), force_sd=np.full(est.n_forces, 0.05), correlation_time_s=20.0)
    pushed = replace(gusts, vectors=gusts.vectors.copy())
    pushed.vectors[:, est.index["rudder_effectiveness"]] = -0.3
    run, rudder = est.free_run(pushed, 0, free), 0.7 * est.segments[0].rudder
    model, order = est.model, [("psi", "r", "u", "v", "x", "y").index(name) for name in est.model.states]
    alone = simulate(model, inputs_of(model, rudder[free:]), est.segments[0].step_s, run[free][order])
    assert np.abs(alone[:, :4] - run[free:][:, order][:, :4]).max() < 1e-9
