"""Random values and neighbours of parameters."""

import numpy as np
import pytest
from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

from helmbench.estimation.methods_only.tuning import abc


@pytest.mark.parametrize(
    "distribution",
    [
        FloatDistribution(-2.0, 3.0),
        FloatDistribution(1e-2, 1e10, log=True),
        FloatDistribution(-1.0, 2.0, step=0.25),
        IntDistribution(-3, 12, step=3),
        IntDistribution(1, 1000, log=True),
    ],
    ids=repr,
)
def test_encode_and_decode_are_inverse(distribution, rng):
    for _ in range(50):
        value = abc.random_value(distribution, rng)
        place = abc.encode(distribution, value)
        assert 0.0 <= place <= 1.0
        assert abc.decode(distribution, place) == pytest.approx(value, rel=1e-12)
        assert distribution._contains(value)


def test_a_logarithmic_domain_is_uniform_in_the_logarithm(rng):
    distribution = FloatDistribution(1e-2, 1e10, log=True)
    values = np.array([abc.random_value(distribution, rng) for _ in range(400)])
    assert 0.35 < np.mean(values < 1e4) < 0.65


def test_a_neighbour_differs_in_one_parameter(rng):
    space = {
        "real": FloatDistribution(0.0, 1.0),
        "scale": FloatDistribution(1e-3, 1e3, log=True),
        "count": IntDistribution(1, 5),
        "kind": CategoricalDistribution(["a", "b", "c"]),
    }
    for _ in range(300):
        own, other = ({name: abc.random_value(found, rng) for name, found in space.items()} for _ in range(2))
        found = abc.neighbour(space, own, other, rng)
        changed = [name for name in space if found[name] != own[name]]
        assert len(changed) == 1
        assert all(space[name]._contains(space[name].to_internal_repr(found[name])) for name in space)


def test_equal_sources_still_move(rng):
    space = {"count": IntDistribution(1, 3), "kind": CategoricalDistribution(["a", "b"])}
    same = {"count": 1, "kind": "a"}
    assert {tuple(abc.neighbour(space, same, same, rng).values()) for _ in range(100)} > {(2, "a"), (1, "b")}


def test_a_category_that_all_sources_share_can_change(rng):
    space = {"real": FloatDistribution(0.0, 1.0), "kind": CategoricalDistribution(["a", "b", "c"])}
    own, other = {"real": 0.2, "kind": "a"}, {"real": 0.7, "kind": "a"}
    assert {abc.neighbour(space, own, other, rng)["kind"] for _ in range(100)} == {"a", "b", "c"}


def test_bounds_reflect(rng):
    distribution = FloatDistribution(2.0, 4.0)
    assert all(2.0 < abc.neighbour_value(distribution, 2.0, 4.0, rng) < 4.0 for _ in range(100))
    assert all(2.0 < abc.neighbour_value(distribution, 3.9, 2.1, rng) < 4.0 for _ in range(100))
