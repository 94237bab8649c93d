"""Runs one case of a diagnosis suite: inject, diagnose, score, time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...execution import guarded, measured_cost, quiet
from .judge import KNOWN, detectable, gain, judge, size_rows
from .plan import ORACLE, CaseSpec

if TYPE_CHECKING:
    from ...faults import Injected

WARM_SAMPLES = 120


def injected_of(spec: CaseSpec) -> Injected:
    """The records of a case, the same at every call."""
    from ...faults import Case, inject

    strength = spec.strength if spec.injected else "medium"
    return inject(Case(spec.vessel, spec.injected, strength, gusts=spec.gusts), np.random.default_rng(spec.seed))


def execute(spec: CaseSpec) -> dict[str, Any]:
    """Inject, diagnose and score one case: `{"key", "row", "parameters"}` with built-in types only.

    An error inside becomes the row's status and error.
    """
    return guarded(spec, lambda row: _diagnose_and_score(spec, row))


def warm(specs: Iterable[CaseSpec]) -> None:
    """Compile the kernels of the cases' vessels in this process, so that workers only load them."""
    first = {(spec.vessel, spec.maker): spec for spec in reversed(list(specs)) if spec.method != ORACLE}
    for spec in (first[key] for key in sorted(first)):
        with quiet():
            _warm_one(spec)


def _warm_one(spec: CaseSpec) -> None:
    """Diagnose a short clean record; what fails here fails again, with its reason, when the case is run."""
    from ....diagnosis.registry import find
    from ....models.errors import CannotFit, FitFailed
    from ....models.model import resolve
    from ...faults import Case, inject

    found = inject(Case(spec.vessel), np.random.default_rng(0))
    short = [record.slice(0, WARM_SAMPLES) for record in (*found.train[:1], *found.held_out[:1])]
    try:
        find(spec.maker)().diagnose(resolve(spec.vessel), short[:1], short[1:], _options(spec))
    except (CannotFit, FitFailed, ValueError, ArithmeticError):
        return


def _diagnose_and_score(spec: CaseSpec, row: dict[str, Any]) -> list[dict[str, Any]]:
    """Fill in the row; returns the rows of the sizes."""
    from ....diagnosis.registry import find
    from ....models.model import resolve

    case = injected_of(spec)
    row |= {"noncentrality": case.noncentrality, "detectable": detectable(case) if spec.injected else None}
    diagnoser = find("innovations" if spec.method == ORACLE else spec.maker)()
    model, options = resolve(spec.vessel), _options(spec)
    with measured_cost(row):
        found = diagnoser.diagnose(model, case.train, case.held_out, options)
    row |= judge(found, spec.group, spec.injected) | gain(found)
    return size_rows(found, case) if spec.group in KNOWN and spec.method != ORACLE else []


def _options(spec: CaseSpec) -> Any:
    """Defaults of the command for a base model that is exact, seeded by the case; the oracle is given the true causes
    that have parameters."""
    from ....diagnosis.causes.registry import bank
    from ....diagnosis.options import Options

    given = tuple(cause for cause in spec.injected if cause in {c.id for c in bank()})
    return Options(coefficient_sd=0.0, seed=spec.seed % 2**32, only=given if spec.method == ORACLE else None)
