"""Any scikit-learn regressor as a method: it learns accelerations from states and inputs and is simulated like a model.

    sklearn:HuberRegressor
    sklearn:SVR,C=100,epsilon=0.02
    sklearn:my_package.my_module.MyRegressor          any class that keeps scikit-learn's contract

A 3-DOF model gives the features u, v, r and the inputs, and the targets u_dot, v_dot, r_dot; a first-order response
model r and the rudder, and r_dot; a second-order one r_dot, r, the rudder and its rate, and r_ddot.  Heading and
position are no features: the ship's behaviour does not depend on them.  Features and targets are scaled to zero mean
and unit variance first.  A black box has no parameters and is scored on its predictions only.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.scaled import Scaled, evenly_spaced, fit_scaled, unchecked
from ..estimation.methods_only.tuning.space import Choice, Domain, Integer, Real
from ..estimation.regression.schemes import regression_samples
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from ..models.model import Model
from ..models.suggestions import near
from .base import SCHEME, Wrapper
from .learner import in_order
from .options import Option, option, whole

PREFIX = "sklearn:"
ROWS: Mapping[str, int] = {
    "GaussianProcessRegressor": 400,
    "KernelRidge": 2000,
    "MLPRegressor": 5000,
    "NuSVR": 2000,
    "SVR": 2000,
    "TheilSenRegressor": 2000,
}
"""Most training rows, evenly spaced, for regressors whose time grows faster than the number of rows."""
_SVR = {"C": Real(1e-2, 1e4, log=True), "epsilon": Real(1e-4, 1.0, log=True), "gamma": Real(1e-3, 10.0, log=True)}
_TREES = {"min_samples_leaf": Integer(1, 100, log=True), "max_depth": Integer(2, 20)}
SPACES: Mapping[str, Mapping[str, Domain]] = {
    "ElasticNet": {"alpha": Real(1e-6, 1.0, log=True), "l1_ratio": Real(0.0, 1.0)},
    "ExtraTreesRegressor": _TREES,
    "HistGradientBoostingRegressor": {
        "learning_rate": Real(0.01, 0.5, log=True),
        "max_iter": Integer(20, 500, log=True),
        "min_samples_leaf": Integer(2, 100, log=True),
    },
    "HuberRegressor": {"epsilon": Real(1.0, 5.0), "alpha": Real(1e-8, 1e2, log=True)},
    "KNeighborsRegressor": {"n_neighbors": Integer(1, 100, log=True), "weights": Choice("uniform", "distance")},
    "KernelRidge": {"alpha": Real(1e-8, 10.0, log=True)},
    "Lasso": {"alpha": Real(1e-6, 1.0, log=True)},
    "MLPRegressor": {"alpha": Real(1e-7, 1.0, log=True), "learning_rate_init": Real(1e-4, 1e-1, log=True)},
    "NuSVR": {"C": _SVR["C"], "nu": Real(0.05, 0.95), "gamma": _SVR["gamma"]},
    "RandomForestRegressor": _TREES,
    "Ridge": {"alpha": Real(1e-8, 1e4, log=True)},
    "SVR": _SVR,
}
"""What `tuned:sklearn:NAME` tunes, for features and targets of unit variance."""


@lru_cache(maxsize=64)
def regressor(name: str) -> type[BlackBox]:
    """The method `sklearn:name`; `name` is a regressor of scikit-learn or the dotted path of a class like one.

    Raises
    ------
    BadInput : there is no such regressor, or it cannot be made without further objects.
    """
    cls = find_regressor(name)
    space = SPACES.get(name, {})
    defaults = make_regressor(cls, name).get_params(deep=False)
    wrapped = {one: Option(one, defaults[one], domain=space.get(one)) for one in sorted(defaults)}
    summary = next(iter((inspect.getdoc(cls) or name).splitlines()))
    attributes = {
        "name": PREFIX + name,
        "title": summary.rstrip("."),
        "regressor": cls,
        "search_space": space,
        "wrapped": wrapped,
        "__module__": __name__,
        "__doc__": BlackBox.__doc__,
    }
    return type(f"BlackBox{cls.__name__}", (BlackBox,), attributes)


class BlackBox(Wrapper):
    """A regressor of accelerations; made by `regressor`, which sets the class's name.  Its other options are those of
    the regressor."""

    kind = "black box"
    regressor: ClassVar[Any]
    rows: int | None = option(
        None,
        "most training rows, evenly spaced over all records; default: all, or fewer for the regressors in `ROWS`",
        whole(1),
    )
    scheme: str = SCHEME
    seed: int = option(0, "random state of regressors that take one, unless it is an option of its own", whole(0))

    def check_options(self) -> None:
        super().check_options()
        made = self.new_regressor(1)
        try:
            if hasattr(made, "_parameter_constraints"):  # scikit-learn's own regressors; not those of other packages
                made._validate_params()
        except ValueError as error:
            raise BadInput(str(error)) from error

    def __reduce__(self):
        return _unpickled, (self.name.removeprefix(PREFIX), self.get_params(deep=False))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        parts, names = regression_samples(in_order(records), model, self.scheme), features_of(model)
        motions = [place for place, symbol in enumerate(model.regression_states) if symbol in names]
        x = np.vstack([np.column_stack([part.states[:, motions], part.inputs]) for part in parts])
        y = np.vstack([part.accelerations for part in parts])
        chosen = evenly_spaced(len(x), self.rows or ROWS.get(self.regressor.__name__))
        learnt = fit_scaled(x[chosen], y[chosen], self.new_regressor)
        predictor = BlackBoxPredictor(tuple(model.states), tuple(model.inputs), names, learnt)
        return Fit(np.empty(0), predictor=predictor, extra={"rows": len(chosen)})

    def new_regressor(self, n_features: int) -> Any:
        """A new regressor with the options; where its own default kernel has no noise, with one that has."""
        options = dict(self.inner_options)
        if "random_state" in self.options and options.get("random_state") is None:
            options["random_state"] = self.seed
        if self.regressor.__name__ == "GaussianProcessRegressor" and options.get("kernel") is None:
            from ..estimation.methods_only.black_box.limited import kernel_with_noise

            options["kernel"] = kernel_with_noise(n_features)
        return make_regressor(self.regressor, self.name, **options)


def _unpickled(name: str, options: Mapping[str, Any]) -> BlackBox:
    return regressor(name)(**options)


def features_of(model: Model) -> tuple[str, ...]:
    """Symbols of the states and inputs that accelerations depend on."""
    return *(symbol for symbol in model.regression_states if symbol not in ("psi", "x", "y")), *model.regression_inputs


@dataclass(frozen=True)
class BlackBoxPredictor:
    """Accelerations learnt by regressors, integrated by RK4 with one step a sample and inputs linear in between.

    `states` and `inputs` are the model's; `features` (d,) names what the accelerations `learnt` (k,) are functions of.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    features: tuple[str, ...]
    learnt: Scaled

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `estimation.results.predictor.Predictor`; rows from where it diverges on are nan."""
        states = np.full((len(inputs), len(start)), np.nan)
        states[0] = start
        with unchecked(), np.errstate(all="ignore"):
            for k in range(len(inputs) - 1):
                states[k + 1] = self._advance(states[k : k + 1], inputs[k : k + 1], inputs[k + 1 : k + 2], dt)[0]
                if not np.isfinite(states[k + 1]).all():
                    break
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row at once, as `estimation.results.predictor.Predictor`."""
        with unchecked(), np.errstate(all="ignore"):
            return self._advance(states, inputs[: len(states)], inputs[1 : len(states) + 1], dt)

    def _advance(self, x: np.ndarray, before: np.ndarray, after: np.ndarray, dt: float) -> np.ndarray:
        """States (B, n) dt later, inputs (B, nu) going from `before` to `after`."""
        slope, half = (after - before) / dt, (before + after) / 2.0
        k1 = self._rates(x, before, slope)
        k2 = self._rates(x + 0.5 * dt * k1, half, slope)
        k3 = self._rates(x + 0.5 * dt * k2, half, slope)
        k4 = self._rates(x + dt * k3, after, slope)
        return x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def _rates(self, x: np.ndarray, inputs: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """State derivatives (B, n); q = r_dot stands in the place of w."""
        state = dict(zip(("q" if name == "w" else name for name in self.states), x.T, strict=True))
        current = dict(zip(self.inputs, inputs.T, strict=True))
        current["delta_rate"] = slope[:, self.inputs.index("delta")]
        known = state | current
        found = self.learnt(np.column_stack([known[name] for name in self.features])).T
        rates = {"psi": state["r"]}
        if len(found) == 3:
            u, v, cos, sin = state["u"], state["v"], np.cos(state["psi"]), np.sin(state["psi"])
            rates |= {"u": found[0], "v": found[1], "r": found[2], "x": u * cos - v * sin, "y": u * sin + v * cos}
        else:
            rates |= {"q": found[0], "r": state["q"]} if "q" in state else {"r": found[0]}
        return np.column_stack([rates[name] for name in state])


MODULES = (
    "linear_model", "svm", "ensemble", "gaussian_process", "neighbors", "neural_network", "kernel_ridge", "tree",
    "cross_decomposition", "dummy", "compose", "multioutput", "isotonic",
)  # fmt: skip


def find_regressor(name: str) -> Any:
    """The class of a regressor of scikit-learn, or of a dotted path to a class that keeps scikit-learn's contract.

    Raises
    ------
    BadInput : there is no such class.
    """
    return _dotted(name) if "." in name else _in_sklearn(name)


def _in_sklearn(name: str) -> Any:
    for module in MODULES:
        found = getattr(import_module(f"sklearn.{module}"), name, None)
        if isinstance(found, type):
            return found
    from sklearn.utils import all_estimators

    known = [known for known, _ in all_estimators(type_filter="regressor")]
    hint = near(name, known, most=3, cutoff=0.5) or "scikit-learn's user guide lists them"
    raise BadInput(f"scikit-learn has no regressor {name!r}", hint=hint)


def _dotted(path: str) -> Any:
    module, _, name = path.rpartition(".")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise BadInput(f"no regressor {path!r}: {error}") from error


def make_regressor(cls: Any, name: str, **options: Any) -> Any:
    """A regressor of the class with these options.

    Raises
    ------
    BadInput : the class needs other objects, or is not a regressor that keeps scikit-learn's contract.
    """
    from sklearn.base import is_regressor

    if not (isinstance(cls, type) and all(hasattr(cls, name) for name in ("fit", "predict", "get_params"))):
        raise BadInput(f"{name} is not a regressor that keeps scikit-learn's contract")  # before it is called
    try:
        made = cls(**options)
    except TypeError as error:
        raise BadInput(f"{name} cannot be made from an option text: {error}") from error
    if not is_regressor(made):
        raise BadInput(f"{name} is not a regressor that keeps scikit-learn's contract")
    return made
