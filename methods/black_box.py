"""Any scikit-learn regressor as a method: it learns accelerations from states and inputs and is simulated like a model.

    sklearn:HuberRegressor
    sklearn:SVR,C=100,epsilon=0.02
    sklearn:my_package.my_module.MyRegressor          any class that keeps scikit-learn's contract

A 3-DOF model gives the features u, v, r and the inputs, and the targets u_dot, v_dot, r_dot; a first-order response
model r and the rudder, and r_dot; a second-order one r_dot, r, the rudder and its rate, and r_ddot.  Heading and
position are no features: the ship's behaviour does not depend on them.  Features and targets are brought to zero mean
and unit variance first.  A black box has no parameters and is scored on its predictions only.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from ..models.errors import BadInput
from ._compiled import compiled, stacked
from .base import Fit, FitFailed, Method
from .ls import check_scheme
from .regression import accelerations, differences
from .tuning.space import Choice, Domain, Integer, Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

PREFIX = "sklearn:"
ROWS: Mapping[str, int] = {
    "GaussianProcessRegressor": 400,
    "KernelRidge": 2000,
    "MLPRegressor": 5000,
    "NuSVR": 2000,
    "SVR": 2000,
    "TheilSenRegressor": 2000,
}
"""Training rows that regressors whose time grows faster than their number are given, spread evenly over all rows."""
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
MODULES = (
    "linear_model", "svm", "ensemble", "gaussian_process", "neighbors", "neural_network", "kernel_ridge", "tree",
    "cross_decomposition", "dummy", "compose", "multioutput", "isotonic",
)  # fmt: skip
OUTSIDE = 1e3
"""Standard deviations from the training rows beyond which nothing is predicted: the run has diverged."""


@lru_cache(maxsize=64)
def regressor(name: str) -> type[BlackBox]:
    """The method `sklearn:name`; `name` is a regressor of scikit-learn or the dotted path of a class like one.

    Raises
    ------
    BadInput : there is no such regressor, or it cannot be made without further objects.
    """
    cls = _dotted(name) if "." in name else _in_sklearn(name)
    _make(cls, name)
    summary = next(iter((inspect.getdoc(cls) or name).splitlines()))
    facts = {
        "name": PREFIX + name,
        "title": f"black box: {summary}".rstrip("."),
        "regressor": cls,
        "search_space": SPACES.get(name, {}),
    }
    return type(f"BlackBox{cls.__name__}", (BlackBox,), {**facts, "__module__": __name__, "__doc__": BlackBox.__doc__})


def _in_sklearn(name: str) -> Any:
    for module in MODULES:
        found = getattr(import_module(f"sklearn.{module}"), name, None)
        if isinstance(found, type):
            return found
    from sklearn.utils import all_estimators

    close = get_close_matches(name, [known for known, _ in all_estimators(type_filter="regressor")], n=3, cutoff=0.5)
    hint = f"did you mean {', '.join(close)}?" if close else "scikit-learn's user guide lists them"
    raise BadInput(f"scikit-learn has no regressor {name!r}", hint=hint)


def _dotted(path: str) -> Any:
    module, _, name = path.rpartition(".")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise BadInput(f"no regressor {path!r}: {error}") from error


def _make(cls: Any, name: str, **options: Any) -> Any:
    from sklearn.base import is_regressor

    try:
        made = cls(**options)
    except TypeError as error:
        raise BadInput(f"{name} cannot be made from an option text: {error}") from error
    if not (hasattr(made, "get_params") and is_regressor(made)):
        raise BadInput(f"{name} is not a regressor that keeps scikit-learn's contract")
    return made


class BlackBox(Method):
    """A regressor of accelerations; made by `regressor`, which sets the class's name.

    Parameters
    ----------
    rows : most training rows, spread evenly over all records; default: all, but see `ROWS`.
    scheme : difference scheme of the accelerations, see `regression`.
    seed : random state of regressors that have one and are not given it.
    Everything else goes to the regressor.
    """

    regressor: ClassVar[Any]
    own: ClassVar[tuple[str, ...]] = ("rows", "scheme", "seed")

    def __init__(self, rows: int | None = None, scheme: str = "midpoint", seed: int = 0, **options: Any) -> None:
        self.rows, self.scheme, self.seed = rows, scheme, seed
        self.options: dict[str, Any] = {}
        self.set_params(**options)

    @classmethod
    def option_names(cls) -> list[str]:
        return [*cls.own, *sorted(cls.regressor().get_params(deep=False))]

    def get_params(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.own} | self.options

    def set_params(self, **options: Any) -> Self:
        super().set_params(**{name: value for name, value in options.items() if name not in self._others()})
        self.options |= {name: value for name, value in options.items() if name in self._others()}
        return self

    def _others(self) -> set[str]:
        return set(self.option_names()) - set(self.own)

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if self.rows is not None and not self.rows >= 1:
            raise BadInput(f"rows is {self.rows!r}, a positive number is needed")
        validate = getattr(self._fresh(1), "_validate_params", None)
        try:
            validate() if validate is not None else None
        except ValueError as error:
            raise BadInput(str(error)) from error

    def __reduce__(self):
        return _remake, (self.name.removeprefix(PREFIX), self.get_params())

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        parts = differences(records, model, self.scheme)
        states, inputs = features_of(model)
        x = np.vstack([_features(part.states, part.inputs, model, states, inputs) for part in parts])
        y = np.vstack([part.accelerations for part in parts])
        chosen = spread(len(x), self.rows or ROWS.get(self.regressor.__name__))
        predictor = learn(x[chosen], y[chosen], self._fresh, model)
        return Fit(np.empty(0), predictor=predictor, extra={"rows": len(chosen)})

    def _fresh(self, n_features: int) -> Any:
        """A new regressor with the options, and a start that suits noisy records where its own default does not."""
        options = dict(self.options)
        known = self._others()
        if "random_state" in known and options.get("random_state") is None:
            options["random_state"] = self.seed
        if self.regressor.__name__ == "GaussianProcessRegressor" and options.get("kernel") is None:
            options["kernel"] = _noisy_kernel(n_features)
        return _make(self.regressor, self.name, **options)


def _remake(name: str, options: Mapping[str, Any]) -> BlackBox:
    return regressor(name)(**options)


def _noisy_kernel(n_features: int) -> Any:
    """A smooth function with a length scale for each feature, in white noise; scikit-learn's default has no noise."""
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    scales: Any = np.full(n_features, 3.0)
    smooth = ConstantKernel(1.0, (1e-3, 1e4)) * RBF(scales, (1e-1, 1e3))
    return smooth + WhiteKernel(1e-2, (1e-10, 1e1))


def features_of(model: Model) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """States and inputs of the model that accelerations depend on."""
    return tuple(s for s in model.regression_states if s not in ("psi", "x", "y")), tuple(model.regression_inputs)


def _features(states: np.ndarray, inputs: np.ndarray, model: Model, names, input_names) -> np.ndarray:
    columns = [states[:, model.regression_states.index(name)] for name in names]
    return np.column_stack([*columns, *(inputs[:, model.regression_inputs.index(name)] for name in input_names)])


def spread(count: int, most: int | None) -> np.ndarray:
    """Indices of at most `most` of `count` rows, evenly spread."""
    if most is None or count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).round().astype(np.int64)


def _scaling(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean (k,) and spread (k,) of columns (N, k); 1 for a column that does not vary."""
    sd = values.std(axis=0)
    mean = values.mean(axis=0)
    return mean, np.where(sd > 1e-12 * np.maximum(np.abs(mean), 1e-300), sd, 1.0)


def learn(x: np.ndarray, y: np.ndarray, fresh: Callable[[int], Any], model: Model) -> BlackBoxPredictor:
    """Fit regressors made by `fresh` to scaled features x (N, d) and accelerations y (N, k)."""
    if not (np.isfinite(x).all() and np.isfinite(y).all() and np.abs(x).max() < 1e100 and np.abs(y).max() < 1e100):
        raise FitFailed("states or accelerations are not finite")
    (x_mean, x_scale), (y_mean, y_scale) = _scaling(x), _scaling(y)
    scaled, target = (x - x_mean) / x_scale, (y - y_mean) / y_scale
    regressors = _fitted(scaled, target, fresh)
    states, inputs = features_of(model)
    return BlackBoxPredictor(
        states=tuple(model.states),
        inputs=tuple(model.inputs),
        features=(*states, *inputs),
        is_3dof=accelerations(model) == 3,
        x_mean=x_mean,
        x_scale=x_scale,
        y_mean=y_mean,
        y_scale=y_scale,
        regressors=regressors,
        fast=compiled(regressors, scaled[spread(len(scaled), 50)]),
    )


def _fitted(x: np.ndarray, y: np.ndarray, fresh: Callable[[int], Any]) -> tuple[Any, ...]:
    """One regressor for all targets where it can, else one for each."""
    from sklearn.utils import get_tags

    first = fresh(x.shape[1])
    try:
        if y.shape[1] > 1 and get_tags(first).target_tags.multi_output:
            return (first.fit(x, y),)
        return tuple(fresh(x.shape[1]).fit(x, column) for column in y.T)
    except (TypeError, ValueError, ArithmeticError) as error:
        raise FitFailed(f"{type(first).__name__}: {error}") from error


@dataclass(frozen=True)
class BlackBoxPredictor:
    """Accelerations learnt by regressors, integrated by RK4 with one step a sample and inputs linear in between.

    `states` and `inputs` are the model's; `features` (d,) names what the regressors take, scaled by x_mean and x_scale
    (d,); their predictions are scaled back by y_mean and y_scale (k,).  `fast` gives the same as they, if it is set.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    features: tuple[str, ...]
    is_3dof: bool
    x_mean: np.ndarray
    x_scale: np.ndarray
    y_mean: np.ndarray
    y_scale: np.ndarray
    regressors: tuple[Any, ...]
    fast: Callable[[np.ndarray], np.ndarray] | None

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `predictor.Predictor`; rows from where it diverges on are nan."""
        states = np.full((len(inputs), len(start)), np.nan)
        states[0] = start
        with _unchecked(), np.errstate(all="ignore"):
            for k in range(len(inputs) - 1):
                states[k + 1] = self._advance(states[k : k + 1], inputs[k : k + 1], inputs[k + 1 : k + 2], dt)[0]
                if not np.isfinite(states[k + 1]).all():
                    break
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row at once, as `predictor.Predictor`."""
        with _unchecked(), np.errstate(all="ignore"):
            return self._advance(states, inputs[: len(states)], inputs[1 : len(states) + 1], dt)

    def accelerations(self, features: np.ndarray) -> np.ndarray:
        """Accelerations (B, k) at features (B, d); nan where they are far from everything learnt."""
        scaled = (features - self.x_mean) / self.x_scale
        inside = (np.abs(scaled) < OUTSIDE).all(axis=1)
        found = np.full((len(scaled), len(self.y_mean)), np.nan)
        if inside.all():
            found = self._predict(scaled)
        elif inside.any():
            found[inside] = self._predict(scaled[inside])
        return found * self.y_scale + self.y_mean

    def _predict(self, scaled: np.ndarray) -> np.ndarray:
        return stacked(self.regressors, scaled) if self.fast is None else self.fast(scaled)

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
        given = dict(zip(self.inputs, inputs.T, strict=True))
        given["delta_rate"] = slope[:, self.inputs.index("delta")]
        known = state | given
        found = self.accelerations(np.column_stack([known[name] for name in self.features])).T
        rates = {"psi": state["r"]} | (self._planar(state, found) if self.is_3dof else self._yaw(state, found))
        return np.column_stack([rates[name] for name in state])

    def _planar(self, state: Mapping[str, np.ndarray], found: np.ndarray) -> dict[str, np.ndarray]:
        u, v, cos, sin = state["u"], state["v"], np.cos(state["psi"]), np.sin(state["psi"])
        return {"u": found[0], "v": found[1], "r": found[2], "x": u * cos - v * sin, "y": u * sin + v * cos}

    def _yaw(self, state: Mapping[str, np.ndarray], found: np.ndarray) -> dict[str, np.ndarray]:
        return {"q": found[0], "r": state["q"]} if "q" in state else {"r": found[0]}


def _unchecked():
    """Context in which scikit-learn does not check arrays and options that are known to be right."""
    from sklearn import config_context

    return config_context(assume_finite=True, skip_parameter_validation=True)
