"""Planted nulls: forces of effects of other records, which leave a record's own rudder and motion no part in them."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.bench.faults.frames import foreign_forces, plan_of
from helmbench.bench.faults.ships import ship
from helmbench.models.errors import BadInput

EFFECTS = {
    "mariner": Effect("yaw_damping_quadratic", {"Nrr": -3e-4}),
    "kvlcc2-l7": Effect("rudder_effectiveness", {"e": -0.2}),
    "cargo": Effect("rudder_delay", {"tau": 2.0}),
}


def made(vessel, seed=1, **facts):
    time = 300.0 if ship(vessel).clock > 0.5 else 80.0
    case = FaultCase(
        vessel, effects=(EFFECTS[vessel],), train=("turn:20",) * 2, held_out=("zigzag:20/20",), duration_s=time, **facts
    )
    return inject(replace(case, noise=0.0), np.random.default_rng(seed))


@pytest.mark.parametrize("vessel", EFFECTS)
def test_a_force_is_that_of_the_effect_backwards_and_without_mean(vessel):
    case = made(vessel)
    run = case.frames.run(case.effects, 2, calm=True)
    plan = plan_of(ship(vessel), case.effects, 2)
    found = foreign_forces(plan, ship(vessel), run)
    assert found.shape == (len(run.states), 3) and np.allclose(found.mean(axis=0), 0.0, atol=1e-9 * np.abs(found).max())
    yaw = found[::-1, 2]
    follows = run.states[:, 2] * np.abs(run.states[:, 2]) if vessel == "mariner" else run.rudder[::2] - run.hull[::2]
    share = np.corrcoef(yaw, follows)[0, 1]
    assert abs(share) > 0.9


def test_a_record_with_the_force_of_another_has_nothing_of_its_own_effect():
    """The first training record of two equal turns gets the force of the second, the last one that of the first."""
    own, foreign = made("mariner"), made("mariner", foreign=True)
    clean = inject(replace(own.case, effects=()), np.random.default_rng(1))
    r = [case.train[0].column("yaw_rate_rad_s") for case in (own, foreign, clean)]
    assert np.max(np.abs(r[0] - r[2])) > 0.0 and np.max(np.abs(r[1] - r[2])) > 0.0
    late = slice(-60, None)  # steady turn: the own effect acts on, the other one began so backwards and has no mean
    assert np.abs(np.mean(r[1][late] - r[2][late])) < 0.5 * np.abs(np.mean(r[0][late] - r[2][late]))
    assert [len(case.truth) for case in (own, foreign, clean)] == [1, 1, 0]


def test_the_same_seed_makes_the_same_records_and_the_same_held_out_truth():
    first, again = made("kvlcc2-l7", foreign=True), made("kvlcc2-l7", foreign=True)
    for one, other in zip(first.train, again.train, strict=True):
        assert np.array_equal(one.column("heading_rad"), other.column("heading_rad"))
    (truth,) = first.held_out_without_gusts()
    error = truth.column("yaw_rate_rad_s") - first.held_out[0].column("yaw_rate_rad_s")
    assert np.max(np.abs(error)) < 1e-12


@pytest.mark.parametrize("facts", [{"causes": ("yaw_rate_bias",)}, {"causes": ("rudder_delay",), "gusts": "slow"}])
def test_sensors_and_gusts_are_refused(facts):
    with pytest.raises(BadInput, match="planted nulls"):
        FaultCase("mariner", foreign=True, **facts)
