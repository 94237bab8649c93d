"""Records and truths of a row."""

import dataclasses

import numpy as np
import pytest

from helmbench.bench.kinds.identification import problems
from helmbench.bench.kinds.identification.problems import Task, derived_parameters, problem
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

TASK = Task("remus-kt", "remus-kt", "kt", ("prbs:20deg/1s",), ("prbs:20deg/1s",), noise="low")


def test_the_model_is_blank_and_the_truth_is_the_vessels():
    made = problem(TASK)
    assert np.isnan(made.model.coefficients).all()
    assert made.truth.values == resolve("remus-kt").parameters and made.truth.kind == "given"
    assert made.n_samples == made.train[0].n


def test_held_out_records_are_noise_free_and_never_the_training_ones():
    made = problem(TASK)
    calm = problem(dataclasses.replace(TASK, noise="none"))
    for column in ("heading_rad", "rudder_rad"):
        assert np.array_equal(made.held_out[0].column(column), calm.held_out[0].column(column))
        assert not np.array_equal(made.held_out[0].column(column), calm.train[0].column(column))


def test_seeds_change_training_records_and_leave_held_out_ones():
    one, other = problem(TASK), problem(dataclasses.replace(TASK, seed=1))
    assert not np.array_equal(one.train[0].column("rudder_rad"), other.train[0].column("rudder_rad"))
    assert np.array_equal(one.held_out[0].column("rudder_rad"), other.held_out[0].column("rudder_rad"))


def test_duration_and_step_are_those_of_training_and_held_out_records():
    made = problem(dataclasses.replace(TASK, duration_s=5.0, dt_s=0.05))
    assert (made.train[0].n, made.held_out[0].n) == (101, 101)


def test_the_bound_grows_with_the_noise_and_is_absent_without():
    low, high = (problem(dataclasses.replace(TASK, noise=noise)).truth for noise in ("low", "high"))
    assert all(high.crb_sd[name] > 5 * low.crb_sd[name] > 0 for name in low.values)
    none = problem(dataclasses.replace(TASK, noise="none")).truth
    assert none.crb_sd == {} and none.identifiable == low.identifiable == dict.fromkeys(low.values, True)


def test_what_a_short_straight_run_does_not_tell_is_not_identifiable():
    # rudder midships throughout: nothing is excited, so no parameter can be told
    truth = problem(dataclasses.replace(TASK, train=("straight",))).truth
    assert set(truth.identifiable.values()) == {False}


def test_the_linearised_mariner_is_the_published_one():
    found = derived_parameters(resolve("mariner"), resolve("nomoto-2"))
    assert set(found) == {"K", "T1", "T2", "T3"}
    published = {"K": 0.18499, "T1": 117.978, "T2": 7.763, "T3": 18.530}
    assert {name: abs(value) for name, value in found.items()} == pytest.approx(published, rel=1e-4)
    first = derived_parameters(resolve("mariner"), resolve("nomoto-1"))
    assert first["T"] == pytest.approx(117.978 + 7.763 - 18.530, rel=1e-4)


def test_the_gain_has_the_sign_of_the_models_rudder():
    mariner, model = resolve("mariner"), resolve("nomoto-1")
    assert (mariner.positive_rudder, model.positive_rudder) == ("port", "starboard")
    assert derived_parameters(mariner, model)["K"] > 0
    turned = dataclasses.replace(model, positive_rudder="port")
    assert derived_parameters(mariner, turned)["K"] < 0


def test_the_linearised_remus_is_that_of_the_specification():
    found = derived_parameters(resolve("remus"), dataclasses.replace(resolve("kt"), positive_rudder="port"))
    sizes = {name: abs(value) for name, value in found.items()}
    assert sizes == pytest.approx({"T1": 1.28357, "T2": 2.22531, "K": 2.54034, "T3": 1.59523}, rel=1e-5)


def test_damping_has_no_derived_value():
    found = derived_parameters(resolve("mariner"), resolve("nomoto-2-cubic"))
    assert set(found) == {"h", "g", "T3", "K"}


@pytest.mark.parametrize(("vessel", "model"), [("response-1", "nomoto-1"), ("mariner", "integrator")])
def test_other_pairs_have_no_truth(vessel, model):
    task = dataclasses.replace(TASK, vessel=vessel, source=model, model=model, train=("zigzag:20/20",))
    assert problem(task).truth == problems.Truth()


def test_derived_truths_are_marked():
    task = dataclasses.replace(TASK, vessel="mariner", source="nomoto-1", model="nomoto-1", train=("zigzag:20/20",))
    truth = problem(task).truth
    assert truth.kind == "derived" and set(truth.values) == {"K", "T"} and set(truth.crb_sd) == {"K", "T"}


def test_faults_of_the_input_are_bad_input():
    for change in ({"train": ("zigzag:20",)}, {"noise": "loud"}, {"vessel": "titanic"}, {"disturbance": "wind:9@0"}):
        with pytest.raises(BadInput):
            problem(dataclasses.replace(TASK, **change))


def test_thinned_and_shortened_records_are_parts_of_the_whole_ones():
    whole = problem(TASK)
    part = problem(dataclasses.replace(TASK, thinning=4, length=0.5))
    for long, short in zip(whole.train, part.train, strict=True):
        n = -(-long.n // 2)
        assert np.array_equal(short.time_s, long.time_s[:n:4])
        for name, values in short.channels.items():
            assert np.array_equal(values, long.channels[name][:n:4])
    assert [r.n for r in part.held_out] == [r.n for r in whole.held_out]
    bounds = (whole.truth.crb_sd, part.truth.crb_sd)
    assert all(bounds[1][name] > bounds[0][name] for name in bounds[0])
