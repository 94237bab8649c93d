"""Many runs in one call against `simulate`, run by run."""

import numpy as np
import pytest

import helmbench
from helmbench.datasets import indices
from helmbench.models.errors import BadInput
from helmbench.models.model import list_vessels, resolve

RUNS = 35
AGREE = 1e-9


def assert_run(found, expected):
    """The channels that were kept agree with a single run's: to 1e-9 of the largest value, with the same gaps."""
    for name, values in found.channels.items():
        alone = expected.column(name)
        np.testing.assert_array_equal(np.isnan(values), np.isnan(alone), err_msg=name)
        np.testing.assert_allclose(values, alone, rtol=0.0, atol=AGREE * np.nanmax(np.abs(alone)) + 1e-15, err_msg=name)


@pytest.mark.parametrize("vessel", list(list_vessels()))
def test_every_vessel_sails_many_noisy_random_runs_as_it_sails_one(vessel, seed):
    start = seed % 10**6
    found = helmbench.simulate_many(vessel, "prbs:5deg/4s", RUNS, noise="medium,dropout=2%", seed=start)
    for run in (0, 1, 31, 32, RUNS - 1):
        assert_run(
            found.record(run), helmbench.simulate(vessel, "prbs:5deg/4s", noise="medium,dropout=2%", seed=start + run)
        )


@pytest.mark.parametrize("disturbance", ["wind:10@60deg+current:0.5@120deg", "waves:3/9@50deg", "none"])
def test_weather_and_noise_are_those_of_single_runs(disturbance, seed):
    start, setting = seed % 10**6, {"noise": "high", "disturbance": disturbance, "duration_s": 150.0}
    found = helmbench.simulate_many("mariner", "zigzag:20/10", RUNS, seed=start, **setting)
    for run in (0, 31, 32):
        alone = helmbench.simulate("mariner", "zigzag:20/10", seed=start + run, **setting)
        assert set(found.channels) == set(alone.channels)
        assert_run(found.record(run), alone)
        assert found.record(run).meta == alone.meta


def test_instruments_are_those_of_single_runs():
    from dataclasses import replace

    model = replace(resolve("mariner"), instruments={"yaw_rate_bias": 0.001, "rudder_offset": 0.01, "wave_rms": 0.001})
    found = helmbench.simulate_many(model, "zigzag:10/10", 3, noise="low")
    for run in range(3):
        assert_run(found.record(run), helmbench.simulate(model, "zigzag:10/10", noise="low", seed=run))


def test_parameters_and_initial_states_vary_from_run_to_run(rng):
    model = resolve("response-1")
    gains = model.parameters["K"] * rng.uniform(0.8, 1.2, RUNS)
    headings = rng.uniform(-1.0, 1.0, RUNS)
    found = helmbench.simulate_many(model, "turn:10", RUNS, parameters={"K": gains}, initial={"psi": headings})
    np.testing.assert_array_equal(found.channels["heading_rad"][:, 0], headings)
    for run in (0, RUNS - 1):
        own = model.with_coefficients(model.from_parameters({**model.parameters, "K": gains[run]}))
        alone = helmbench.simulate(own, "turn:10").column("yaw_rate_rad_s")
        np.testing.assert_allclose(found.channels["yaw_rate_rad_s"][run], alone, atol=AGREE * np.abs(alone).max())


def test_commands_may_be_given_sample_by_sample(rng):
    commands = 0.1 * rng.standard_normal((RUNS, 60))
    found = helmbench.simulate_many("mariner", commands, RUNS, channels=["rudder_command_rad", "sway_m_s"])
    assert found.time_s[-1] == pytest.approx(29.5)
    np.testing.assert_array_equal(found.channels["rudder_command_rad"], commands)
    texts = ["turn:10", "turn:10:port"]
    mixed = helmbench.simulate_many("mariner", texts, 2, channels=["heading_rad"])
    assert mixed.channels["heading_rad"][0, -1] > 0.0 > mixed.channels["heading_rad"][1, -1]
    assert [mixed.record(run).meta.manoeuvre for run in (0, 1)] == texts


def test_only_what_is_asked_for_is_kept():
    whole = helmbench.simulate_many("mariner", "zigzag:10/10", 3, noise="low")
    part = helmbench.simulate_many("mariner", "zigzag:10/10", 3, noise="low", channels=["heading_rad"], every=7)
    assert list(part.channels) == ["heading_rad"]
    np.testing.assert_array_equal(part.channels["heading_rad"], whole.channels["heading_rad"][:, ::7])
    np.testing.assert_array_equal(part.time_s, whole.time_s[::7])
    nothing = helmbench.simulate_many("mariner", "zigzag:10/10", 3, channels=[], indices=["first_overshoot"])
    assert not nothing.channels and nothing.indices["first_overshoot"].shape == (3,)


@pytest.mark.parametrize(
    ("vessel", "manoeuvre"),
    [("mariner", "zigzag:10/10"), ("kvlcc2-l7", "zigzag:20/20:port"), ("cargo", "zigzag:20/20")],
)
def test_overshoots_are_those_of_the_records(vessel, manoeuvre, rng):
    model = resolve(vessel)
    sets = model.coefficients * (1.0 + 0.05 * rng.standard_normal((RUNS, model.coefficients.size)))
    found = helmbench.simulate_many(
        model, manoeuvre, RUNS, coefficients=sets, indices=["first_overshoot", "second_overshoot"]
    )
    assert np.isfinite(found.indices["first_overshoot"]).any()
    for run in np.flatnonzero(~found.diverged):
        angles = (
            indices.overshoots(found.record(run))
            if np.ptp(np.sign(found.record(run).column("rudder_command_rad"))) == 2
            else []
        )
        expected = [*angles, np.nan, np.nan][:2]
        np.testing.assert_array_equal([values[run] for values in found.indices.values()], expected)


def test_a_zigzag_that_ends_before_its_overshoot_has_none():
    found = helmbench.simulate_many("mariner", "zigzag:10/10", 2, duration_s=60.0, indices=["second_overshoot"])
    assert np.isnan(found.indices["second_overshoot"]).all()


def test_turning_indices_are_those_of_the_records():
    names = ["advance", "transfer", "tactical_diameter"]
    found = helmbench.simulate_many("mariner", ["turn:35", "turn:15:port", "straight"], 3, indices=names)
    for run in (0, 1):
        expected = indices.turning_indices(found.record(run))
        assert [found.indices[name][run] for name in names] == [expected[name] for name in names]
    assert all(np.isnan(values[2]) for values in found.indices.values())


def test_a_diverging_run_is_nan_and_the_others_stay():
    model = resolve("response-1")
    unstable = np.array([model.parameters["T"], -model.parameters["T"] / 50.0])
    found = helmbench.simulate_many(model, "turn:20", 2, parameters={"T": unstable}, indices=["first_overshoot"])
    assert found.diverged.tolist() == [False, True]
    assert np.isnan(found.channels["heading_rad"][1]).all() and np.isfinite(found.channels["heading_rad"][0]).all()
    assert "1 diverged" in repr(found)


def test_the_number_of_threads_changes_nothing():
    one, two = (helmbench.simulate_many("s175", "prbs:10deg/10s", RUNS, noise="low", jobs=jobs) for jobs in (1, 2))
    for name, values in one.channels.items():
        np.testing.assert_array_equal(values, two.channels[name])


def test_the_tables_have_a_row_a_sample_and_a_row_a_run():
    found = helmbench.simulate_many(
        "mariner", "zigzag:10/10", 3, channels=["heading_rad"], indices=["first_overshoot"], seed=5
    )
    samples, runs = found.to_dataframe(), found.indices_to_dataframe()
    assert list(samples.columns) == ["run", "time_s", "heading_rad"]
    assert len(samples) == 3 * found.time_s.size
    np.testing.assert_array_equal(samples[samples["run"] == 2]["heading_rad"], found.channels["heading_rad"][2])
    assert list(runs["seed"]) == [5, 6, 7] and list(runs.columns) == ["run", "seed", "diverged", "first_overshoot"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"runs": 0}, "must be at least 1"),
        ({"every": 0}, "must be at least 1"),
        ({"parameters": {"nothing": 1.0}}, "no parameter 'nothing'"),
        ({"parameters": {"K": np.ones(3)}}, "has the shape"),
        ({"parameters": {"K": np.nan}}, "not finite"),
        ({"coefficients": np.ones((2, 9))}, "have the shape"),
        ({"coefficients": np.full(3, np.inf)}, "run 0 are not finite"),
        ({"coefficients": np.ones(3), "parameters": {"K": 1.0}}, "both parameters and coefficients"),
        ({"initial": {"u": 1.0}}, "no state 'u'"),
        ({"channels": ["roll_rad"]}, "no channel 'roll_rad'"),
        ({"indices": ["overshoot"]}, "no index 'overshoot'"),
        ({"manoeuvre": ["turn:5"] * 3}, "3 manoeuvres for 2 runs"),
        ({"manoeuvre": ["turn:5", "turn:5@euler"]}, "some do not"),
        ({"manoeuvre": np.zeros((3, 10))}, "commands have the shape"),
        ({"disturbance": "wind:5@0deg"}, "does not apply"),
        ({"seed": -1}, "is negative"),
        ({"model": "nomoto-1"}, "no coefficients"),
        ({"runs": 10**9}, "are free"),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_what_cannot_be_simulated_is_told_in_one_line(change, said):
    given = {"model": "response-1", "manoeuvre": "turn:10", "runs": 2, **change}
    with pytest.raises(BadInput, match=said) as caught:
        helmbench.simulate_many(**given)
    assert "\n" not in str(caught.value)


def test_there_is_no_run_behind_the_last():
    with pytest.raises(BadInput, match="no run 2"):
        helmbench.simulate_many("response-1", "turn:10", 2).record(2)
