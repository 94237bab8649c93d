"""A run that is given twice in another form is told by the noise of its sensors; two runs never are."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from helmbench.datasets import copies as module
from helmbench.datasets.copies import check_no_copies, same_run
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.measured import data_dir, load, stems
from helmbench.models.errors import BadInput

TURNED = ("yaw_rate_rad_s", "heading_rad", "sway_m_s", "rudder_rad")


def resampled(r, step, start=0.0):
    time = np.arange(r.time_s[0] + start, r.time_s[-1], step)
    channels = {n: r.heading_unwrapped() if n == "heading_rad" else v for n, v in r.channels.items()}
    return replace(r, time_s=time, channels={n: np.interp(time, r.time_s, v) for n, v in channels.items()})


def rounded(r, rng):
    steps = {n: 0.003 * np.nanstd(v) for n, v in r.channels.items() if np.nanstd(v) > 0.0}
    return r.with_channels(**{n: np.round(r.column(n) / s) * s for n, s in steps.items()})


def with_noise(r, rng):
    return r.with_channels(**{n: v + 0.002 * np.nanstd(v) * rng.standard_normal(r.n) for n, v in r.channels.items()})


FORMS = {
    "rounded": rounded,
    "with noise": with_noise,
    "jittered": lambda r, rng: replace(r, time_s=r.time_s + 0.05 * r.dt * rng.standard_normal(r.n)),
    "resampled": lambda r, rng: resampled(r, 1.5 * r.dt),
    "another phase": lambda r, rng: resampled(r, r.dt, rng.uniform(0.1, 0.9) * r.dt),
    "half a step on": lambda r, rng: resampled(r, r.dt, 0.5 * r.dt),
    "turned": lambda r, rng: r.with_channels(heading_rad=r.heading_unwrapped() + 0.7),
    "mirrored": lambda r, rng: r.with_channels(**{n: -r.column(n) for n in TURNED}),
    "cut and rounded": lambda r, rng: rounded(r.slice(r.n // 5, None), rng),
}


def run(manoeuvre, seed, noise="medium"):
    return generate(Case("kvlcc2-l7", manoeuvre, noise, seed=seed, duration_s=200.0, dt_s=0.5))


@pytest.mark.parametrize("form", FORMS)
def test_a_run_in_another_form_is_told(form, rng):
    first = run("zigzag:20/20", int(rng.integers(2**31)))
    second = replace(FORMS[form](first, rng), name="again")
    with pytest.raises(BadInput, match=r"again: (is the run of|shares|holds)"):
        check_no_copies([first, second])
    found = same_run([first], [second])
    assert found is not None and found[2].mirrored == (form == "mirrored")


@pytest.mark.parametrize("noise", ["none", "medium"])
def test_two_runs_are_two(noise, rng):
    """Also those of one seed, which share their noise in different manoeuvres, and one manoeuvre of two seeds."""
    seed = int(rng.integers(2**31))
    manoeuvres = [("zigzag:20/20", seed), ("turn:25", seed), ("zigzag:10/10:port", seed), ("zigzag:20/20", seed + 1)]
    runs = [run(*one, noise) for one in manoeuvres[: 3 if noise == "none" else 4]]
    assert same_run(runs) is None


@pytest.mark.skipif(not (data_dir() / "kvlcc2").exists(), reason="the measured development sets are not here")
def test_measured_runs_are_all_different(rng):
    runs = [load("kvlcc2-hsva", stem).thinned(8) for stem in stems("kvlcc2-hsva")]
    assert same_run(runs) is None
    told = [same_run([r], [FORMS[form](r, rng)]) for r in runs[:2] for form in FORMS if form != "cut and rounded"]
    assert all(told), told


def test_short_records_and_gaps_are_left_alone():
    record = run("zigzag:20/20", 1)
    for first, second in combinations([record.slice(0, 20), record.slice(30, 50), record.slice(0, 3)], 2):
        assert same_run([first], [second]) is None
    late = replace(record, time_s=np.concatenate([record.time_s[:200], record.time_s[200:] + 1e9]))
    assert same_run([record], [late]) is None


@pytest.mark.parametrize("size", [1e9, 1e300])
def test_a_gross_error_ends_in_no_warning(size, rng):
    first = run("zigzag:20/20", int(rng.integers(2**31)))
    values = first.column("yaw_rate_rad_s").copy()
    values[int(rng.integers(values.size))] = size
    second = run("zigzag:20/20", int(rng.integers(2**31)))
    assert same_run([first.with_channels(yaw_rate_rad_s=values)], [second]) is None


@pytest.mark.parametrize("few", ["MOST_PAIRS", "MOST_NUMBERS"])
def test_the_first_pair_of_many_is_told_however_many_are_compared_at_a_time(few, rng, monkeypatch):
    """Records of several steps and lengths; two of them are there twice."""
    runs = [run("zigzag:20/20", int(rng.integers(2**31))) for _ in range(4)]
    runs[1], runs[3] = resampled(runs[1], 0.8), runs[3].slice(0, 250)
    many = [*runs, rounded(runs[2], rng), resampled(runs[1], 0.8, 0.3)]
    monkeypatch.setattr(module, few, 1)
    first, second, _ = same_run(many)
    assert first is many[1] and second is many[5]
    first, second, _ = same_run(many[2:5][::-1], runs)
    assert first is many[4] and second is many[2]
