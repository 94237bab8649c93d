"""Compiled forms of fitted regressors."""

import numpy as np
import pytest
from sklearn.kernel_ridge import KernelRidge
from sklearn.linear_model import LinearRegression

from helmbench.estimation.methods_only.black_box.compiled import KERNELS, NETWORKS, TREES, compiled, stacked
from helmbench.estimation.methods_only.black_box.scaled import fit_regressors
from helmbench.methods.registry import make

FORMS = {
    "Ridge": NETWORKS,
    "LinearSVR": NETWORKS,
    "SVR": KERNELS,
    "NuSVR": KERNELS,
    "DecisionTreeRegressor": TREES,
    "RandomForestRegressor,n_estimators=10": TREES,
    "ExtraTreesRegressor,n_estimators=10": TREES,
    "HistGradientBoostingRegressor,max_iter=20": TREES,
    "MLPRegressor,activation=tanh,solver=lbfgs,tol=1.0": NETWORKS,
    "SVR,kernel=poly": None,
    "KNeighborsRegressor": None,
    "GradientBoostingRegressor,n_estimators=10": None,
}


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("outputs", [1, 3])
def test_fast_forms_predict_as_scikit_learn(name, outputs, rng):
    x = rng.normal(size=(300, 4))
    y = np.column_stack([np.sin(x[:, 0] + place) + x[:, 1] * x[:, 2] for place in range(outputs)])
    regressors = fit_regressors(x, y, make(f"sklearn:{name}").new_regressor)
    fast = compiled(regressors, x[:20])
    assert (None if fast is None else fast.form) == FORMS[name]
    if fast is not None:
        elsewhere = 2.0 * rng.normal(size=(600, 4))
        np.testing.assert_allclose(fast(elsewhere), stacked(regressors, elsewhere), rtol=1e-8, atol=1e-8)


def test_a_sum_whose_terms_cancel_agrees_up_to_their_rounding(rng):
    x = rng.normal(size=(300, 4))
    y = np.sin(x[:, :2]) + 0.1 * rng.normal(size=(300, 2))
    regressor = KernelRidge(kernel="rbf", alpha=1e-9, gamma=0.01).fit(x, y)
    terms = np.abs(regressor.dual_coef_).sum(axis=0).max()
    fast, expected = compiled((regressor,), x), stacked((regressor,), x)
    assert terms > 1e8 * np.abs(expected).max()
    assert np.abs(fast(x) - expected).max() < 1e-14 * terms


def test_a_form_that_does_not_agree_is_not_used(rng):
    class Rounding(LinearRegression):
        def predict(self, X):
            return np.round(super().predict(X), 3)

    x = rng.normal(size=(50, 2))
    assert compiled((Rounding().fit(x, x[:, 0]),), x) is None


@pytest.mark.parametrize("wrong", [{"coef_": np.ones(3)}, {"coef_": np.ones((2, 2))}])
def test_arrays_of_other_shapes_are_not_used(wrong, rng):
    class OwnRegression(LinearRegression):
        def predict(self, X):
            return X @ np.ones(2)

    x = rng.normal(size=(50, 2))
    regressor = OwnRegression().fit(x, x[:, 0])
    vars(regressor).update(wrong)
    assert compiled((regressor,), x) is None
