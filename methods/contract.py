"""The contract of methods, as checks that third parties can run on their own methods.

    import pytest
    from helmbench.methods.contract import CHECKS

    @pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
    def test_contract(check):
        check(MyMethod)

or all at once: `check_method(MyMethod)`.  A check raises AssertionError with the reason.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np

from ..datasets.generator import Case, generate
from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate, predictor_of
from ..estimation.records.series import MEASURED, series_of
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.model import Model, resolve
from .base import KINDS, Method

VESSELS = ("response-1", "remus-kt", "kvlcc2-l7")
"""A first-order and a second-order response model and a 3-DOF model."""
SAMPLES = 160
"""Samples of a record: enough for two executions of a zigzag; a slow method is checked in seconds."""
GARBAGE_SAMPLES = 100
"""Samples of a record of garbage, on which methods that search iterate longest."""
FACTORS = {"_rad_s": (np.rad2deg(1.0), "_deg_s"), "_rad": (np.rad2deg(1.0), "_deg"), "_m_s": (3600.0 / 1852.0, "_kn")}


@cache
def sample(vessel: str) -> tuple[Model, tuple[Record, ...]]:
    """A blanked model and two short records of it with low sensor noise."""
    model = resolve(vessel)
    dt, duration = model.suite["dt_s"], SAMPLES * model.suite["dt_s"]
    cases = [Case(vessel, f"zigzag:{pair}", "low", seed=3, duration_s=duration, dt_s=dt) for pair in ("20/20", "10/10")]
    return model.blanked(), tuple(map(generate, cases))


def fit_or_none(method: Method, records: Record | Sequence[Record], model: Model) -> Estimate | None:
    """The estimate, or None if the method refuses or fails by CannotFit or FitFailed."""
    try:
        return method.fit(records, model)
    except (CannotFit, FitFailed) as error:
        assert str(error).strip() and "\n" not in str(error), "an error states its reason in one line"
        return None


def brief(cls: type[Method]) -> Method:
    """The method with the options with which a fit takes seconds."""
    return cls(**cls.brief)


@cache
def _fitted(cls: type[Method]) -> tuple[Method, tuple[tuple[Model, tuple[Record, ...], Estimate], ...]]:
    """A method, and what it was fitted to: the sample vessels that it applies to, each with an estimate.

    The records are the method's own copies: where it changes them, `check_records_are_not_changed` finds that, and no
    other method is given them.
    """
    method = brief(cls)
    copies = [(model, pickle.loads(pickle.dumps(records))) for model, records in map(sample, VESSELS)]
    found = [(model, records, fit_or_none(method, records, model)) for model, records in copies]
    found = [(model, records, estimate) for model, records, estimate in found if estimate is not None]
    assert found, f"{cls.name} fits none of {', '.join(VESSELS)}"
    return method, tuple(found)


def applicable(cls: type[Method]) -> tuple[tuple[Model, tuple[Record, ...], Estimate], ...]:
    """The sample vessels that the method can be fitted to, each with an estimate."""
    return _fitted(cls)[1]


def free_run(estimate: Estimate) -> np.ndarray:
    """States (M + 1, n) that the estimate predicts for the first sample record from its first state."""
    model, records = sample(estimate.model.id)
    series = series_of(records[0].turned(model.positive_rudder), model, MEASURED)
    return predictor_of(estimate).simulate(series.inputs, series.dt, series.start)


def same(first: Estimate, second: Estimate, relative: float) -> bool:
    """Whether coefficients agree to `relative`, or to a thousandth of their standard errors.

    Without coefficients the free runs are compared, to `relative` of each state's largest value.
    """
    if first.predictor is not None:
        runs = free_run(first), free_run(second)
        with np.errstate(invalid="ignore"):
            largest = np.where(np.isfinite(runs[0]), np.abs(runs[0]), 0.0).max(axis=0)
            close = np.abs(runs[0] - runs[1]) <= relative * largest
        return bool(np.all(close | (np.isnan(runs[0]) & np.isnan(runs[1]))))
    error = np.zeros(len(first.coefficients))
    if relative and first.covariance is not None:
        error = 1e-3 * np.sqrt(np.diag(first.covariance))
    difference = np.abs(first.coefficients - second.coefficients)
    return bool(np.all(difference <= relative * np.abs(first.coefficients) + error))


def check_options(cls: type[Method]) -> None:
    """`get_params`, `set_params` and `sklearn.base.clone` work on the options; unknown options are refused."""
    method = cls()
    options = method.get_params(deep=False)
    assert cls.name and cls.name == cls.name.strip() and " " not in cls.name, "name is a short identifier"
    assert cls.title, "title is one line about the method"
    assert cls.kind in KINDS, f"kind is one of {', '.join(KINDS)}"
    assert method.set_params(**options) is method
    assert options.items() <= method.get_params(deep=True).items(), "get_params(deep=True) leaves out an option"
    copy = _cloned(method)
    assert type(copy) is cls and copy is not method and copy.get_params(deep=False) == options, "clone changes options"
    taken = not _is_bad_input(lambda: method.set_params(no_such_option=1))
    assert not taken, "set_params takes an option that the method does not have"


def _is_bad_input(action: Callable[[], object]) -> bool:
    """Whether an action raises BadInput."""
    try:
        action()
    except BadInput:
        return True
    return False


def _cloned(method: Method) -> Method:
    from sklearn.base import clone

    try:
        return cast("Method", clone(method))
    except (RuntimeError, TypeError) as error:
        raise AssertionError(f"sklearn.base.clone fails: {error}") from error


def check_estimate(cls: type[Method]) -> None:
    """The estimate is finite, has the model's parameter names, and holds the model with its coefficients."""
    for model, _, estimate in applicable(cls):
        assert (estimate.method, estimate.variant) == (cls.name, cls().variant)
        assert estimate.wall_s >= 0.0 and estimate.cpu_s >= 0.0 and estimate.n_iterations >= 0
        if cls.kind in ("black box", "floor"):
            assert estimate.predictor is not None and estimate.coefficients.shape == (0,), (
                "a black box has coefficients"
            )
            continue
        assert estimate.coefficients.shape == (len(model.coordinates),)
        assert np.isfinite(estimate.coefficients).all()
        assert tuple(estimate.parameters) == tuple(estimate.stderr) == model.parameter_names
        assert np.array_equal(estimate.model.coefficients, estimate.coefficients)
        published = [*estimate.parameters.values()]
        assert np.array_equal([*estimate.model.parameters.values()], published, equal_nan=True)


def check_predictions(cls: type[Method]) -> None:
    """Free runs and one-step predictions have the right shapes, agree with each other, and diverge without an error."""
    for model, records, estimate in applicable(cls):
        predictor, series = predictor_of(estimate), series_of(records[0], model, MEASURED)
        run = free_run(estimate)
        assert run.shape == (len(series.inputs), len(model.states)), "a free run has a row for every sample"
        hidden = [place for place, name in enumerate(model.states) if name == "w"]  # a step may give w itself or q
        compared = np.setdiff1d(np.arange(len(model.states)), hidden)
        assert np.allclose(run[0, compared], series.start[compared], rtol=1e-12, atol=0.0), (
            "a free run begins at its start"
        )
        one = predictor.step(run[:1] if not hidden else series.start[None], series.inputs[:2], series.dt)
        assert one.shape == (1, len(model.states)), "a step is one row for every state given"
        agree = np.allclose(one[0, compared], run[1, compared], rtol=1e-6, atol=1e-9)
        assert agree or not np.isfinite(run).all(), "a step differs from the first step of the free run"
        with np.errstate(all="ignore"):
            diverged = predictor.simulate(1e6 * (1.0 + series.inputs), series.dt, series.start)
        assert diverged.shape == run.shape, "a run that diverges keeps its shape"


def check_covariance(cls: type[Method]) -> None:
    """A covariance, if there is one, is symmetric and positive semidefinite where it is finite."""
    for model, _, estimate in applicable(cls):
        if estimate.covariance is None:
            continue
        covariance = estimate.covariance
        assert covariance.shape == (len(model.coordinates),) * 2
        known = np.isfinite(np.diag(covariance))
        block = covariance[np.ix_(known, known)]
        scale = np.sqrt(np.abs(np.diag(block)))
        scale = np.where(scale > 0.0, scale, 1.0)
        block = block / np.outer(scale, scale)
        assert np.abs(block - block.T).max(initial=0.0) < 1e-6, "the covariance is not symmetric"
        assert np.linalg.eigvalsh((block + block.T) / 2.0).min(initial=0.0) > -1e-6, "a variance is negative"


def check_trajectory(cls: type[Method]) -> None:
    """A trajectory, if there is one, has shape (N, p) and increasing times, and ends at the estimate."""
    for model, _, estimate in applicable(cls):
        if estimate.trajectory is None:
            continue
        assert estimate.trajectory_time_s is not None, "a trajectory needs its times"
        assert estimate.trajectory.shape == (len(estimate.trajectory_time_s), len(model.coordinates))
        assert (np.diff(estimate.trajectory_time_s) >= 0.0).all()
        assert np.allclose(estimate.trajectory[-1], estimate.coefficients, rtol=1e-9, atol=0.0)


def check_deterministic(cls: type[Method]) -> None:
    """The same records give the same estimate, bit for bit, by the same and by a cloned method."""
    method, found = _fitted(cls)
    for model, records, estimate in found:
        for again in (method.fit(records, model), _cloned(method).fit(records, model)):
            assert same(estimate, again, 0.0), "two equal fits differ"


def check_one_record(cls: type[Method]) -> None:
    """One record gives the same estimate as a list with that record."""
    for model, records, _ in applicable(cls):
        alone, listed = fit_or_none(brief(cls), records[0], model), fit_or_none(brief(cls), records[:1], model)
        assert (alone is None) == (listed is None), "fit does not take one record"
        assert alone is None or listed is None or same(alone, listed, 0.0), "one record differs from a list of one"


def check_truth_is_not_used(cls: type[Method]) -> None:
    """A model with its true coefficients gives the same estimate as one without."""
    for model, records, estimate in applicable(cls):
        known = brief(cls).fit(records, resolve(model.id))
        assert same(estimate, known, 0.0), "the method uses the true coefficients"


def check_record_order(cls: type[Method]) -> None:
    """The order of the records does not matter, unless `order_matters` is True."""
    for model, records, estimate in applicable(cls):
        swapped = brief(cls).fit(records[::-1], model)
        assert np.isfinite(swapped.coefficients).all()
        if not cls.order_matters:
            assert same(estimate, swapped, 1e-6), "the order of the records matters, but order_matters is False"


def check_units(cls: type[Method]) -> None:
    """A file in degrees and knots gives the same estimate as the record in SI units."""
    from ..datasets.io import read_record

    for model, records, estimate in applicable(cls):
        with tempfile.TemporaryDirectory() as folder:
            files = [_in_degrees(record, Path(folder) / f"{i}.csv") for i, record in enumerate(records)]
            read = [read_record(file, model.positive_rudder) for file in files]
        read = [replace(r, time_s=record.time_s) for r, record in zip(read, records, strict=True)]
        close = 1e-5 if estimate.predictor is None else 0.05  # a tree's threshold is a jump
        assert same(estimate, brief(cls).fit(read, model), close), "the estimate depends on the units of the file"


def _in_degrees(record: Record, path: Path) -> Path:
    columns = {"time_s": record.time_s}
    for name, values in record.channels.items():
        ending = next((ending for ending in FACTORS if name.endswith(ending)), None)
        factor, unit = FACTORS[ending] if ending else (1.0, "")
        columns[name.removesuffix(ending or "") + unit if ending else name] = values * factor
    rows = [",".join(columns), *(",".join(map(repr, row)) for row in np.column_stack([*columns.values()]).tolist())]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def check_rudder_sign(cls: type[Method]) -> None:
    """A record with the other rudder sign, also in its metadata, gives the same estimate."""
    for model, records, estimate in applicable(cls):
        other = "port" if model.positive_rudder == "starboard" else "starboard"
        turned = [record.turned(model.positive_rudder).turned(other) for record in records]
        assert same(estimate, brief(cls).fit(turned, model), 0.0), "the rudder sign of the metadata is ignored"


def check_gaps(cls: type[Method]) -> None:
    """Gaps of one sample and longer ones, in every channel, are accepted."""
    rng = np.random.default_rng(5)
    for model, records, _ in applicable(cls):
        estimate = brief(cls).fit([_with_gaps(record, rng) for record in records], model)
        assert np.isfinite(estimate.coefficients).all()


def _with_gaps(record: Record, rng: np.random.Generator) -> Record:
    channels = {}
    for name, values in record.channels.items():
        with_gaps = values.copy()
        with_gaps[rng.random(record.n) < 0.02] = np.nan
        start = rng.integers(record.n // 2)
        with_gaps[start : start + record.n // 40] = np.nan
        channels[name] = with_gaps
    return record.with_channels(**channels)


def check_too_short(cls: type[Method]) -> None:
    """No record, records of a few samples, and channels without samples are refused by CannotFit."""
    for model, records, _ in applicable(cls):
        empty = records[0].with_channels(**{k: np.full(records[0].n, np.nan) for k in records[0].channels})
        for case in ([], [records[0].slice(0, 1)], [records[0].slice(0, 5)], [empty]):
            _refused(cls, case, model)
        fit_or_none(brief(cls), [records[0].slice(0, 12)], model)


def _refused(cls: type[Method], records: Sequence[Record], model: Model) -> None:
    try:
        brief(cls).fit(records, model)
    except CannotFit:
        return
    except FitFailed as failure:
        raise AssertionError(f"FitFailed ({failure}) where CannotFit is due") from failure
    raise AssertionError(f"{[record.n for record in records]} samples were fitted")


def check_missing_channels(cls: type[Method]) -> None:
    """Records without a rudder, and records with only a rudder, are refused by CannotFit."""
    for model, records, _ in applicable(cls):
        record = records[0]
        without_rudder = record.with_channels(rudder_rad=None, rudder_command_rad=None)
        only_rudder = Record(record.time_s, {"rudder_rad": record.rudder()}, record.name, record.meta)
        for case in (without_rudder, only_rudder):
            _refused(cls, [case], model)


def check_garbage(cls: type[Method]) -> None:
    """A record of noise, constants, huge or infinite values ends in an estimate, CannotFit or FitFailed."""
    rng = np.random.default_rng(7)
    for model, records, _ in applicable(cls):
        record = records[0].slice(0, GARBAGE_SAMPLES)
        for corrupt in GARBAGE:
            channels = {name: corrupt(values, rng) for name, values in record.channels.items()}
            estimate = fit_or_none(brief(cls), record.with_channels(**channels), model)
            assert estimate is None or np.isfinite(estimate.coefficients).all()


GARBAGE: tuple[Callable[[np.ndarray, np.random.Generator], np.ndarray], ...] = (
    lambda values, rng: rng.normal(size=values.size),
    lambda values, rng: np.full(values.size, 0.1),
    lambda values, rng: 1e200 * rng.normal(size=values.size),
    lambda values, rng: np.where(rng.random(values.size) < 0.3, np.inf, values),
)
"""Noise, constants, huge values, infinite values in the place of a channel's values (N,)."""


def check_records_are_not_changed(cls: type[Method]) -> None:
    """Records are not changed by a fit, nor by those of the other checks."""
    for model, records, _ in applicable(cls):
        pristine = sample(model.id)[1]
        assert all(record.equals(own) for record, own in zip(pristine, records, strict=True)), "a record was changed"


def check_pickles(cls: type[Method]) -> None:
    """Methods and estimates can be pickled, as for other processes."""
    assert pickle.loads(pickle.dumps(cls())).get_params(deep=False) == cls().get_params(deep=False)
    for _, _, estimate in applicable(cls):
        back = pickle.loads(pickle.dumps(estimate))
        assert same(estimate, back, 0.0), "an estimate predicts something else after pickling"
        assert np.array_equal(back.coefficients, estimate.coefficients)
        assert np.array_equal([*back.parameters.values()], [*estimate.parameters.values()], equal_nan=True)


def check_saved_model(cls: type[Method]) -> None:
    """The model file of an estimate is read back with the same coefficients; without any, saving is refused."""
    for _, _, estimate in applicable(cls):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.json"
            refused = _is_bad_input(lambda estimate=estimate, path=path: estimate.save(path))
            assert refused == (estimate.predictor is not None), "a model file needs coefficients and nothing else"
            assert refused != path.exists(), "a refused model file exists"
            assert refused or np.array_equal(resolve(path).coefficients, estimate.coefficients)


CHECKS: tuple[Callable[[type[Method]], None], ...] = tuple(
    value for name, value in list(globals().items()) if name.startswith("check_")
)
"""Every check of this module, in order."""


def check_method(cls: type[Method]) -> None:
    """Run all checks on a method class; the first that fails raises AssertionError."""
    for check in CHECKS:
        check(cls)
