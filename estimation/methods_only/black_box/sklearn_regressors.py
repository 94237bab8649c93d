"""scikit-learn regressors by name."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ....models.suggestions import near

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


def kernel_with_noise(n_features: int) -> Any:
    """A smooth Gaussian-process kernel with a length scale for each feature, plus white noise.

    scikit-learn's default kernel has no noise.
    """
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    scales: Any = np.full(n_features, 3.0)
    smooth = ConstantKernel(1.0, (1e-3, 1e4)) * RBF(scales, (1e-1, 1e3))
    return smooth + WhiteKernel(1e-2, (1e-10, 1e1))
