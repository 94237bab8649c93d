"""Runs one row of an identification suite: fit, predict, score, time."""

from __future__ import annotations

from typing import Any

from ....estimation.estimates.estimate import Estimate
from ....estimation.run.prediction import prediction_scores
from ....methods.registry import make
from ....models.model import Model
from ...execution import attempt, guarded, measured_cost, one_line
from ...scores import Outcome, compute
from ...traces import free_run_trace
from .plan import RunSpec
from .problems import FitTask, Truth, problem

WARM_SAMPLES = 60
_WARMED: set[tuple[str, str]] = set()


def execute(spec: RunSpec) -> dict[str, Any]:
    """Fit, score and time one run: `{"key", "row", "parameters"}` with built-in types only.

    An error inside becomes the row's status and error.  A run of the first seed also has its `trace`.
    """
    traces: list[dict[str, Any]] = []
    finished = guarded(spec, lambda row: fit_and_score(spec, row, traces))
    return finished | ({"trace": traces[0]} if traces else {})


def fit_and_score(spec: RunSpec, row: dict[str, Any], traces: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The run itself, its records, its fit and its scores: fills in the row, and adds the trace of a first seed.

    Returns the rows of its parameters.
    """
    row["measured"] = spec.task.measured
    task = problem(spec.task)
    _warm_fit(spec, task)
    row["n_samples"] = task.n_samples
    method = make(spec.maker)
    with measured_cost(row):
        estimate = method.fit(list(task.train), task.model)
    parameters = parameter_rows(task.model, task.truth, estimate)
    prediction = prediction_scores(estimate.model, task.held_out, estimate.predictor)
    row |= {"diverged": prediction["diverged"]} | compute(Outcome(task, estimate, parameters, prediction))
    if spec.task.seed == 0:
        traces.append(free_run_trace(estimate, task.held_out[0]))
    if not estimate.converged:
        row["error"] = one_line(f"not converged: {estimate.message or 'no reason given'}")
    return parameters


def _warm_fit(spec: RunSpec, task: FitTask) -> None:
    """Fit and score a few samples, untimed, once per process, method and model: timed fits then compile nothing.

    Methods that choose their options by trials make one: a trial runs what all of them run.
    """
    if (spec.maker, spec.task.source) in _WARMED:
        return
    _WARMED.add((spec.maker, spec.task.source))
    short = [record.slice(0, WARM_SAMPLES) for record in task.train]

    def action() -> None:
        method = make(spec.maker)
        if hasattr(method, "trials"):
            method.set_params(trials=1)
        estimate = method.fit(short, task.model)
        prediction_scores(estimate.model, task.held_out[:1], estimate.predictor)

    attempt(action)


# ---- Estimated parameters against the true ones: the rows of `parameters.parquet`.


def parameter_rows(model: Model, truth: Truth, estimate: Estimate) -> list[dict[str, Any]]:
    """Rows of `parameters.parquet`, without their keys, in the model's order; none of a black box."""
    rows = []
    if not estimate.parameters:
        return rows
    for name, unit in zip(model.parameter_names, model.parameter_units, strict=True):
        true, value = truth.values.get(name), estimate.parameters[name]
        rows.append(
            {
                "parameter": name,
                "unit": unit,
                "true": true,
                "true_kind": None if true is None else truth.kind,
                "estimate": value,
                "stderr": estimate.stderr.get(name),
                "rel_error": abs(value - true) / abs(true) if true else None,
                "crb_sd": truth.crb_sd.get(name),
                "identifiable": truth.identifiable.get(name),
            }
        )
    return rows
