"""Runs one case of a diagnosis suite: inject, diagnose, score, time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ....diagnosis.causes.registry import bank
from ....diagnosis.options import Options
from ....diagnosis.registry import find
from ....models.model import Model, resolve
from ...execution import attempt, guarded, measured_cost
from .bases import EXACT, base_model, bug_of
from .judge import (
    KNOWN,
    description,
    detectable,
    gain,
    healthy_bias,
    judge,
    judge_names,
    regime_scores,
    size_rows,
    truth_errors,
)
from .plan import ORACLE, PLANTED, CaseSpec

if TYPE_CHECKING:
    from ...faults import Injected

WARM_SAMPLES = 120
_WARMED: set[tuple[str, str]] = set()


def injected_of(spec: CaseSpec, factors: tuple[tuple[str, float], ...] = ()) -> Injected:
    """The records of a case, the same at every call; factors : in what its ship differs from the published one."""
    from ...faults import FaultCase, inject

    strength = spec.strength if spec.injected else "medium"
    facts: dict[str, Any] = {
        "gusts": spec.gusts,
        "foreign": spec.group == PLANTED,
        "factors": factors,
        **RECORDS[spec.records],
    }
    case = FaultCase(spec.vessel, spec.injected, strength, **facts)
    return inject(case, np.random.default_rng(spec.seed))


def base_of(spec: CaseSpec) -> Model:
    """The base model of a case, the same at every call."""
    return base_model(spec.base, spec.vessel, np.random.default_rng([spec.seed, 1]))


def execute(spec: CaseSpec) -> dict[str, Any]:
    """Inject, diagnose and score one case: `{"key", "row", "parameters"}` with built-in types only.

    An error inside becomes the row's status and error.
    """
    return guarded(spec, lambda row: _diagnose_and_score(spec, row))


def _warm_up(spec: CaseSpec) -> None:
    """Diagnose a short clean record, untimed, once per process, diagnoser and vessel: timed cases then compile nothing.

    What fails here fails again, with its reason, when the case is run.
    """
    from ...faults import FaultCase, inject

    if (spec.maker, spec.vessel) in _WARMED or spec.method == ORACLE:
        return
    _WARMED.add((spec.maker, spec.vessel))
    found = inject(FaultCase(spec.vessel), np.random.default_rng(0))
    short = [record.slice(0, WARM_SAMPLES) for record in (*found.train[:1], *found.held_out[:1])]
    attempt(lambda: find(spec.maker)().diagnose(resolve(spec.vessel), short[:1], short[1:], _options(spec)))


def _diagnose_and_score(spec: CaseSpec, row: dict[str, Any]) -> list[dict[str, Any]]:
    """Fill in the row; returns the rows of the sizes."""
    _warm_up(spec)
    case = injected_of(spec)
    row |= {"noncentrality": case.noncentrality, "detectable": detectable(case) if spec.injected else None}
    diagnoser = find("innovations" if spec.method == ORACLE else spec.maker)()
    model, options = base_of(spec), _options(spec)
    with measured_cost(row):
        found = diagnoser.diagnose(model, case.train, case.held_out, options)
    right, wrong = right_names(spec)
    scored = judge_names(found, right) if right else judge(found, spec.group, spec.injected, spec.base)
    row |= scored | description(found, case.effects) | gain(found) | truth_errors(case) | regime_scores(found, case)
    row |= {"healthy_bias": healthy_bias(found, resolve(spec.vessel), right | wrong) if right else None}
    if spec.group not in KNOWN or spec.method == ORACLE:
        return []
    train, held_out = ([record.name for record in side] for side in (case.train, case.held_out))
    return size_rows(found, case.effects, case.case.ship, train, held_out)


def right_names(spec: CaseSpec) -> tuple[frozenset[str], frozenset[str]]:
    """Groups of numbers and causes that name what is wrong with the base model of a case, and the wrong numbers; none
    where the injected cause itself is to be named."""
    from ...faults import kind_of

    bug = bug_of(spec.vessel, spec.base)
    if bug is not None:
        return frozenset(bug.right), bug.numbers
    kinds = [kind_of(name) for name in spec.injected]
    return frozenset(name for kind in kinds for name in kind.right), frozenset()


def _options(spec: CaseSpec) -> Any:
    """Coefficients that are known where the base model is exact, else the defaults of the command, seeded by the case;
    the oracle is given the true causes that have parameters."""
    given = tuple(cause for cause in spec.injected if cause in {c.id for c in bank()})
    sd = 0.0 if spec.base == EXACT else None
    return Options(coefficient_sd=sd, seed=spec.seed % 2**32, only=given if spec.method == ORACLE else None)


# ---- How the records of a case are made: a dimension of diagnosis suites.

RECORDS: Mapping[str, Mapping[str, Any]] = {
    "plain": {},
    "coloured": {"noise_time_s": 5.0},
    "spread": {"spread": 0.3},
    "closed-loop": {"train": ("zigzag:10/10", "zigzag:20/20:port", "zigzag:20/10")},
    "orders": {"command": True, "beside": 0.05},
    "five-three": {
        "train": ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port", "turn:35", "zigzag:20/10"),
        "held_out": ("zigzag:10/10", "turn:20:port", "zigzag:25/15:port"),
    },
    "five-steps": {
        "train": ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port", "steps:30deg/{:g}s", "steps:20deg/{:g}s"),
        "held_out": ("zigzag:10/10", "turn:20:port", "steps:25deg/{:g}s"),
    },
}
"""Name -> what differs from a plain case: sensors' noise with a memory (s, of a 160 m ship), sizes that differ between
records (relative standard deviation), runs in which heading orders the rudder, its order in the place of its angle
(effects as large as needed to be told beside numbers of the ship that are uncertain by 5 %),
five training and three held-out ones (zigzags and turns, or with random rudder angles, which tell a threshold)."""
