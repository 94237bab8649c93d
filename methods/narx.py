"""Difference equations with lags (NARX), learnt by linear, polynomial, kernel, neural and tree regression."""

from __future__ import annotations

from typing import Any

from ..estimation.methods_only.tuning.space import Choice, Integer, Real
from .base import method
from .learner import LAGS, STRIDE, NarxLearner, open_option

INPUT_LAGS: Any = open_option("values of the inputs", Integer(1, 2), 1)
LAGGED: dict[str, Any] = {"stride": STRIDE, "input_lags": INPUT_LAGS}
"""Options of the rows that a regressor learns from."""


@method(
    "arx",
    "linear difference equation with lags (ARX)",
    NarxLearner,
    stride=STRIDE,
    output_lags=open_option("na", LAGS, 1),
    input_lags=open_option("nb", LAGS, 2),
)
def Arx(
    symbols: tuple[str, ...], alpha: float | None = open_option("ridge penalty", Real(1e-9, 1e-1, log=True), 1e-6)
) -> Any:
    """Linear autoregression with inputs (ARX), all outputs at once.

    With outputs z (u, v, r; r of a response model), inputs w and step h,

        (z(t + h) - z(t)) / h = A_1 z(t) + ... + A_na z(t - (na - 1) h) + B_1 w(t) + ... + B_nb w(t - (nb - 1) h) + c

    by ridge regression on averaged samples (`helmbench.estimation.methods_only.black_box.rows`).  Source: Ljung 1999,
    System Identification, section 4.2; the order is chosen by free runs as Nelles 2001 advises, not by one-step errors.
    """
    from ..estimation.methods_only.black_box.terms import TermRegression, monomials

    return TermRegression(monomials(len(symbols), 1), alpha=alpha or 0.0)


@method(
    "narx-poly",
    "polynomial difference equation with lags (NARX)",
    NarxLearner,
    stride=STRIDE,
    output_lags=open_option("values of the outputs", Integer(1, 2), 1),
    input_lags=INPUT_LAGS,
)
def NarxPoly(
    symbols: tuple[str, ...],
    degree: int | None = open_option("of the polynomial, 2 or 3", Choice(2, 3), 2),
    alpha: float | None = open_option("ridge penalty", Real(1e-9, 1e-1, log=True), 1e-4),
) -> Any:
    """Polynomial nonlinear autoregression with inputs (NARX).

    The increment of the outputs over a step is a polynomial of their and the inputs' last values
    (`helmbench.estimation.methods_only.black_box.rows`), with ridge regression on its monomials.  Source: Billings
    2013, Nonlinear System Identification, section 2.4.  All monomials are kept and the penalty is chosen by free runs,
    where Billings selects terms by one-step errors.
    """
    from ..estimation.methods_only.black_box.terms import TermRegression, monomials

    return TermRegression(monomials(len(symbols), degree or 2), alpha=alpha or 0.0)


@method("sindy", "sparse regression on terms of manoeuvring models (SINDy)", NarxLearner, stride=STRIDE)
def Sindy(
    symbols: tuple[str, ...],
    threshold: float | None = open_option(
        "of a term of unit size, relative to the acceleration's spread", Real(1e-3, 0.5, log=True), 0.05
    ),
    alpha: float | None = open_option("ridge penalty", Real(1e-9, 1e-2, log=True), 1e-5),
) -> Any:
    """Sparse identification of nonlinear dynamics with the terms of manoeuvring models.

    Accelerations are sums of few of these terms: all monomials up to degree three of the velocities, yaw rate and
    rudder, and products such as |v| v, |v| r and |r| r.  Coefficients below `threshold` are removed and the others
    fitted again until none is.  Source: Brunton, Proctor & Kutz 2016, PNAS 113(15), 3932.  The regression is the
    package's own, which a test compares with that of pysindy; threshold and penalty are chosen by free runs.
    """
    from ..estimation.methods_only.black_box.rows import SYMMETRIC
    from ..estimation.methods_only.black_box.terms import TermRegression, manoeuvring_terms

    factors = manoeuvring_terms([symbol in SYMMETRIC for symbol in symbols])
    return TermRegression(factors, alpha=alpha or 0.0, threshold=threshold or 0.0)


@method(
    "kernel-ridge",
    "kernel ridge regression (LS-SVR) of a difference equation with lags",
    NarxLearner,
    rows=500,
    **LAGGED,
)
def KernelRidgeNarx(
    symbols: tuple[str, ...],
    alpha: float | None = open_option("penalty, of features and targets of unit size", Real(1e-5, 10.0, log=True), 0.1),
    gamma: float | None = open_option("of the kernel, of features of unit size", Real(3e-3, 0.5, log=True), 0.03),
) -> Any:
    """Kernel ridge regression in NARX form, with squared-exponential kernels.

    f(x) = sum_i a_i exp(-gamma |x - x_i|^2) with (K + alpha I) a = y on the rows of
    `helmbench.estimation.methods_only.black_box.rows`.  Least-squares support vector regression (Suykens & Vandewalle
    1999, Neural Processing Letters 9, 293) is the same with an intercept, C = 1 / alpha.  Kernel width and penalty are
    chosen by the error of free runs, not of one step (Espinoza et al. 2006, Computational Intelligence and Complexity,
    113).
    """
    from sklearn.kernel_ridge import KernelRidge

    options: dict[str, Any] = {"alpha": alpha, "gamma": gamma}
    return KernelRidge(kernel="rbf", **options)


@method(
    "gp-narx",
    "Gaussian process of a difference equation with lags, on a subset of rows",
    NarxLearner,
    rows=400,
    usual_trials=4,
    stride=open_option("step in samples", Integer(2, 16, log=True), 6),
    input_lags=INPUT_LAGS,
)
def GpNarx(symbols: tuple[str, ...]) -> Any:
    """Gaussian-process regression in NARX form.

    The increments of the outputs over a step are Gaussian processes of their and the inputs' last values, with a
    squared-exponential kernel of one length scale for each feature, plus white noise; the scales have the largest
    marginal likelihood.  Sources: Rasmussen & Williams 2006, section 5.4; Kocijan et al. 2005, Math. Comput. Model.
    Dyn. Syst. 11(4), 411.  At most 400 rows, evenly spaced over the records, are used, and 100 of them for the scales
    (subset of data: the cost grows with the cube of their number).  Free runs propagate the mean.
    """
    from ..estimation.methods_only.black_box.limited import gaussian_process

    return gaussian_process(len(symbols))


@method(
    "mlp", "multilayer perceptron of a difference equation with lags", NarxLearner, rows=800, usual_trials=4, **LAGGED
)
def Mlp(
    symbols: tuple[str, ...],
    seed: int,
    units: int | None = open_option("of the hidden layer", Integer(4, 24, log=True), 10),
    alpha: float | None = open_option("penalty on the weights", Real(1e-5, 10.0, log=True), 0.1),
) -> Any:
    """Multilayer perceptron in NARX form: one hidden layer of tanh units, trained by L-BFGS on one-step errors.

    Sources: Narendra & Parthasarathy 1990, IEEE Trans. Neural Networks 1(1), 4; for ships Moreira & Guedes Soares 2003,
    Ocean Engineering 30, 1669.  At most 800 rows, evenly spaced, are used.
    """
    from ..estimation.methods_only.black_box.limited import Perceptron

    return Perceptron((int(units or 1),), alpha=alpha, random_state=seed)


@method(
    "random-forest",
    "random forest of a difference equation with lags",
    NarxLearner,
    rows=3000,
    usual_trials=6,
    **LAGGED,
)
def RandomForest(
    symbols: tuple[str, ...],
    seed: int,
    min_samples_leaf: int | None = open_option("rows in a leaf", Integer(1, 30, log=True), 3),
) -> Any:
    """Random forest in NARX form: the mean of 30 regression trees, each on a bootstrap sample of the rows.

    Source: Breiman 2001, Machine Learning 45, 5.  At most 3,000 rows, evenly spaced, are used.
    """
    from sklearn.ensemble import RandomForestRegressor

    leaf: Any = min_samples_leaf
    return RandomForestRegressor(30, min_samples_leaf=leaf, random_state=seed)


@method("gradient-boosting", "boosted trees of a difference equation with lags", NarxLearner, usual_trials=8, **LAGGED)
def GradientBoosting(
    symbols: tuple[str, ...],
    seed: int,
    max_iter: int | None = open_option("trees of each output", Integer(20, 80, log=True), 40),
    learning_rate: float | None = open_option("of the trees", Real(0.05, 0.4, log=True), 0.2),
    max_leaf_nodes: int | None = open_option("of a tree", Integer(4, 31, log=True), 15),
) -> Any:
    """Histogram gradient boosting in NARX form, one regressor for each output.

    Trees cannot extrapolate: outside the training records the increments are those at their edge.  Sources: Friedman
    2001, Ann. Stat. 29(5), 1189; Ke et al. 2017, NeurIPS 30.  `sklearn:lightgbm.LGBMRegressor` is another
    implementation, on accelerations.
    """
    from sklearn.ensemble import HistGradientBoostingRegressor

    trees: dict[str, Any] = {"max_iter": max_iter, "max_leaf_nodes": max_leaf_nodes}
    rate: Any = learning_rate
    return HistGradientBoostingRegressor(learning_rate=rate, random_state=seed, early_stopping=False, **trees)
