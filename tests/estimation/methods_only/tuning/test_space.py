"""Search spaces."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.tuning.space import Choice, Integer, Real, grid_of
from helmbench.estimation.methods_only.tuning.tune import sampler_of
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput


def test_spaces():
    space = {"a": Real(1e-2, 1e2, log=True), "n": Integer(1, 3), "k": Choice("x", "y")}
    grid = grid_of(space, 50)
    assert grid["k"] == ["x", "y"] and grid["n"] == [1, 2, 3]
    np.testing.assert_allclose(grid["a"], np.geomspace(1e-2, 1e2, 5))
    assert len(grid_of({"a": space["a"]}, 25)["a"]) == 25
    for wrong in (lambda: Real(1.0, 1.0), lambda: Real(0.0, 1.0, log=True), lambda: Integer(3, 2), Choice):
        with pytest.raises(BadInput):
            wrong()
    with pytest.raises(BadInput, match="cmaes"):
        sampler_of("cmaes", space, 10, 0)
    with pytest.raises(BadInput, match="unknown tuner"):
        sampler_of("bees", space, 10, 0)


def test_every_search_space_is_of_the_methods_own_options():
    from helmbench.methods.black_box import SPACES, regressor
    from helmbench.methods.registry import methods

    for cls in [*methods().values(), *(regressor(name) for name in SPACES)]:
        assert set(cls.search_space) <= set(cls.options), cls.name
        for name, domain in cls.search_space.items():
            for value in domain.grid(2):
                make(cls.name).set_params(**{name: value}).check_options()
