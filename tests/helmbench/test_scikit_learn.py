"""Methods keep scikit-learn's conventions for parameters."""

import numpy as np
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


def test_a_grid_search_compares_options_by_free_runs_of_left_out_records():
    from sklearn.model_selection import GridSearchCV

    manoeuvres = ("zigzag:20/20", "zigzag:10/10:port", "turn:20")
    records = [helmbench.simulate("response-1", text, noise="low", seed=k) for k, text in enumerate(manoeuvres)]
    model = helmbench.resolve("nomoto-1-cubic")
    search = GridSearchCV(helmbench.make_method("ridge"), {"penalty": [None, 1e9]}, cv=3)
    search.fit(records, model=model)
    weak, strong = search.cv_results_["mean_test_score"]
    assert weak > 0.99 > strong and search.best_params_ == {"penalty": None}
    best = search.best_estimator_
    assert best.estimate_.parameters == best.fit(records, model).parameters
    assert best.score(records) == pytest.approx(search.score(records))
    assert search.fit(records, model="nomoto-1-cubic").best_estimator_.estimate_.parameters == best.estimate_.parameters
    with pytest.raises(helmbench.BadInput, match="nomoto-9"):
        best.fit(records, "nomoto-9")


def test_a_method_that_was_not_fitted_has_no_score():
    with pytest.raises(helmbench.BadInput, match="not been fitted"):
        helmbench.make_method("ls").score([])


X, Y = np.arange(40.0).reshape(20, 2), np.arange(20.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ((X, Y), "a method takes records, not ndarray; give a Record"),
        ((X.tolist(), Y.tolist()), "a method takes records, not list"),
        (("record.csv", "nomoto-1"), "a method takes records, not str"),
        (({"rudder_rad": Y}, "nomoto-1"), "a method takes records, not dict"),
        ((None, "nomoto-1"), "a method takes records, not NoneType"),
        ((1.0, 2.0), "a method takes records, not float"),
    ],
)
@pytest.mark.parametrize("name", ["ls", "output-error", "mlp"])
def test_the_arrays_of_other_estimators_are_refused(name, given, told):
    with pytest.raises(helmbench.BadInput, match=told):
        helmbench.make_method(name).fit(*given)


@pytest.mark.parametrize(
    ("model", "kind"), [(Y, "ndarray"), (None, "NoneType"), ([1, 2], "list"), (helmbench.Model, "type")]
)
def test_what_is_no_model_is_refused(model, kind):
    record = helmbench.simulate("response-1", "zigzag:20/20")
    with pytest.raises(helmbench.BadInput, match=f"takes a model beside the records, not {kind};"):
        helmbench.make_method("ls").fit(record, model)
    with pytest.raises(helmbench.BadInput, match="records, not NoneType"):
        helmbench.make_method("ls").fit([record, None], "nomoto-1")


def test_scores_take_records_alone():
    record = helmbench.simulate("response-1", "zigzag:20/20")
    method = helmbench.make_method("rls")
    method.fit(record, "nomoto-1")
    with pytest.raises(helmbench.BadInput, match="a method takes records, not ndarray"):
        method.score(X)
