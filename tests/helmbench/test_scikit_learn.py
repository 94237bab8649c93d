"""Methods keep scikit-learn's conventions for parameters."""

import pytest
from sklearn.base import clone

import helmbench

NAMES = [name for name in helmbench.list_methods() if ":" not in name]
"""Registered methods; families such as sklearn:NAME are represented by one member each."""


@pytest.mark.parametrize("name", [*NAMES, "sklearn:SVR", "sklearn:RandomForestRegressor,n_estimators=7", "tuned:ridge"])
def test_methods_are_cloned_and_set(name):
    method = helmbench.make_method(name)
    shallow, deep = method.get_params(deep=False), method.get_params()
    copy = clone(method)
    assert copy is not method and type(copy) is type(method) and repr(copy) == repr(method)
    assert shallow.items() <= deep.items()
    assert copy.set_params(**shallow) is copy and copy.get_params() == deep
    with pytest.raises(helmbench.BadInput, match="has no option 'nothing'"):
        copy.set_params(nothing=1)


@pytest.mark.parametrize("name", NAMES)
def test_a_changed_copy_leaves_the_original_alone(name):
    method = helmbench.make_method(name)
    before = method.get_params()
    copy = clone(method)
    for option, value in before.items():
        if isinstance(value, int | float) and not isinstance(value, bool):
            copy.set_params(**{option: value + 1})
            assert copy.get_params()[option] == value + 1
    assert method.get_params() == before
