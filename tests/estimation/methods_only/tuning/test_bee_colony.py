"""Food sources and their fitness."""

import numpy as np

from helmbench.estimation.methods_only.tuning import bee_colony
from helmbench.estimation.methods_only.tuning.bee_colony import Colony, Role


def test_rank_fitness_separates_small_costs():
    costs = np.array([3e-11, 1e-11, 2e-11, 2e-11])
    np.testing.assert_array_equal(bee_colony.rank_fitness(costs), [1.0, 4.0, 2.5, 2.5])
    assert np.ptp(bee_colony.reciprocal_fitness(costs)) < 1e-10
    np.testing.assert_allclose(bee_colony.reciprocal_fitness(np.array([1.0, np.inf, -2.0])), [0.5, 0.0, 3.0])
    np.testing.assert_array_equal(bee_colony.selection_probabilities(np.zeros(4)), 0.25)


def test_neighbours_of_an_abandoned_source_do_not_bring_it_back():
    colony = Colony(2)
    colony.observe(Role("scout", 0, 0), {"x": 0}, 1.0)
    colony.observe(Role("scout", 0, 1), {"x": 5}, 9.0)
    colony.observe(Role("employed", 0, 0), {"x": 1}, 0.5)
    assert (colony.sources[0].cost, colony.sources[0].failures) == (9.0, 0)
    colony.observe(Role("employed", 0, 1), {"x": 6}, 8.0)
    assert (colony.sources[0].cost, colony.sources[0].params) == (8.0, {"x": 6})
