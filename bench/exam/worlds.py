"""Worlds of an exam: cases of a diagnosis suite, each on a ship of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...models.errors import BadInput
from ...models.model import Model
from ..faults import FaultCase, Injected
from ..faults.effects.base import kind_of
from ..faults.frames import Frames
from ..faults.ships import sister_numbers
from ..kinds.base import RunSelection, Suite
from ..kinds.diagnosis.bases import EXACT, UNSTATED, bug_of, numbers_of, with_numbers
from ..kinds.diagnosis.execute import base_of, injected_of, right_names
from ..kinds.diagnosis.plan import ONE_BUG, ORACLE, REGIME, CaseSpec, plan, stratified

KINDS = ("exact base", "imperfect base", "regime", "sensors", "two at once", "nothing wrong")
SPREAD, MOST = 0.1, 2.0
"""Relative standard deviation of a ship's numbers about the published ones, and where it is cut off."""
DRAWS, SMALLER = 40, 0.9
"""Draws of a ship until one behaves, each with a spread smaller by this factor."""
WILDER, SLOWER = 1.6, 0.6
"""Factors on the published ship's largest yaw rate and smallest surge velocity that a ship may reach."""
HIDDEN = (0.6, 1.6)
"""Factors of a wrong number that the spread of the ships hides."""


@dataclass(frozen=True)
class World:
    """A case, and (name, factor) of the numbers in which its ship differs from the published one.

    A base model can thus not be compared with the published one to see what was changed.
    """

    spec: CaseSpec
    factors: tuple[tuple[str, float], ...]

    @property
    def kind(self) -> str:
        """One of `KINDS`, or the group of a suite of another kind."""
        return kind_of_case(self.spec)

    def injected(self) -> Injected:
        """Its records, the same at every call."""
        return injected_of(self.spec, self.factors)

    def base(self) -> Model:
        """The base model that is handed out."""
        model = base_of(self.spec)
        known = numbers_of(model)
        changed = with_numbers(model, {name: known[name] * factor for name, factor in self.factors})
        return replace(changed, id="model")

    @property
    def base_numbers(self) -> str:
        """What is said of the base model's numbers: exact, or uncertain by the families' priors."""
        return "exact" if self.spec.base == EXACT else "uncertain"

    @property
    def right(self) -> tuple[str, ...]:
        """Names each of which is right where something is wrong with the base model's own numbers, else none."""
        return tuple(sorted(right_names(self.spec)[0]))


def kind_of_case(spec: CaseSpec) -> str:
    """The kind of world that a case makes."""
    if spec.group == ONE_BUG or (spec.group == "injected" and spec.base not in (EXACT, UNSTATED)):
        return "imperfect base"
    if spec.group == "injected":
        return "sensors" if kind_of(spec.injected[0]).on_sensor else "exact base"
    return {"null": "nothing wrong", "pair": "two at once", REGIME: "regime"}.get(spec.group, spec.group)


def draw(suite: Suite, seed: int, count: int, vessels: Sequence[str] = ()) -> list[World]:
    """`count` worlds of a suite in random order; each kind comes once before any comes again.

    Raises
    ------
    BadInput : the suite is of another kind, or has fewer cases.
    """
    if suite.kind != "diagnosis":
        raise BadInput("is no suite of diagnoses", file=f"suite {suite.name}", hint="an exam needs injected effects")
    selection = RunSelection(suite.name, methods=("innovations",), vessels=tuple(vessels), seed=seed)
    cases: dict[str, list[CaseSpec]] = {}
    for spec in plan(suite, selection):
        if spec.method != ORACLE and is_hidden(spec):
            cases.setdefault(kind_of_case(spec), []).append(spec)
    if count > sum(map(len, cases.values())):
        raise BadInput(f"{count} worlds", hint=f"suite {suite.name} has {sum(map(len, cases.values()))} cases")
    rng, chosen = np.random.default_rng([seed, 3]), []
    for kind in stratified(sorted(cases), rng):
        if len(chosen) == count:
            break
        if cases[kind]:
            chosen.append(cases[kind].pop(int(rng.integers(len(cases[kind])))))
    return [World(chosen[int(i)], sister(chosen[int(i)])) for i in rng.permutation(count)]


def is_hidden(spec: CaseSpec) -> bool:
    """Whether a look at the published numbers does not tell what is wrong with the base model of a case."""
    bug = bug_of(spec.vessel, spec.base)
    return bug is None or (not bug.values and all(HIDDEN[0] <= one <= HIDDEN[1] for one in bug.factors.values()))


def sister(spec: CaseSpec) -> tuple[tuple[str, float], ...]:
    """Factors on the published numbers that make the ship of a case, a ship that sails much like it.

    A wrong number of the base model is off the published one by the root of its factor to one side, the ship's own by
    as much to the other.
    """
    rng = np.random.default_rng([spec.seed, 2])
    bug = bug_of(spec.vessel, spec.base)
    between: Mapping[str, float] = {} if bug is None else {name: one**-0.5 for name, one in bug.factors.items()}
    names = sister_numbers(spec.vessel)
    for turn in range(DRAWS):
        error = SPREAD * SMALLER**turn * np.clip(rng.standard_normal(len(names)), -MOST, MOST)
        factors = tuple((n, between.get(n, 1.0) * float(np.exp(e))) for n, e in zip(names, error, strict=True))
        if behaves(spec.vessel, factors):
            return factors
    raise BadInput(f"no ship like {spec.vessel} sails the manoeuvres", hint="take another seed")


def behaves(vessel: str, factors: tuple[tuple[str, float], ...]) -> bool:
    """Whether a ship turns and loses speed in the manoeuvres about as the published one."""
    turns, speeds = zip(*(_extremes(FaultCase(vessel, factors=own)) for own in (factors, ())), strict=True)
    return turns[0] < WILDER * turns[1] and speeds[0] > SLOWER * speeds[1]


def _extremes(case: FaultCase) -> tuple[float, float]:
    """Largest yaw rate, rad/s, and smallest surge velocity, m/s, of the runs of a case without effects."""
    frames = Frames.draw(case, np.random.default_rng(0))
    runs = [frames.run((), i).states for i in range(len(frames.case.train))]
    turn, speed = max(np.abs(run[:, 2]).max() for run in runs), min(run[:, 0].min() for run in runs)
    return (float(turn), float(speed)) if np.isfinite([turn, speed]).all() else (np.inf, -np.inf)
