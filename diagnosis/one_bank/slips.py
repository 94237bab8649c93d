"""Numbers of a base model that hardly any ship has: a unit or a decimal that was mistaken.

Free runs of such a model are so wrong that no linearisation about it leads back, and the sway that its pieces start
with is wrong, too.  What is usual is put in its place where free runs err by far less so, before all else; the fit
moves the number on from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from ...checks.result import Size
from ...estimation.selection.minimiser import minimise
from ...models.coefficient_groups import stated_groups, values_of, with_values
from ..causes.base_coefficients import BaseCoefficients
from ..report.bank import BY_FREE_RUNS
from ..report.verdict import of_motion
from ..result import Finding

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...estimation.selection.minimiser import Fitted
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns

SLIP = 0.5
"""Share of the error of free runs that is left, at most, where what is usual takes the place of a number."""


class Slip(NamedTuple):
    """A number that hardly any ship has, and what is usual.

    title : of its group.  half_range : half of the range that most ships have.  before, after : errors of free runs, as
    shares of the motion.
    """

    name: str
    title: str
    before: float
    usual: float
    half_range: float
    error_before: float
    error_after: float

    @property
    def evidence(self) -> str:
        """In a sentence."""
        before, after = of_motion(self.error_before), of_motion(self.error_after)
        errors = f"free runs err by {before} with the first, by {after} with the second"
        return f"{self.name} is {self.before:.4g}, and {self.usual:.4g} is usual: {errors}"


def without_slips(model: Model, runs_of: Callable[[Model], FreeRuns]) -> tuple[Model, tuple[Slip, ...], Fitted | None]:
    """The model with what is usual in the place of numbers that hardly any ship has, where free runs err by far less;
    these numbers; and the fit of the model as it is, None where there is none.

    runs_of : the free runs of a model.
    """
    slips, base, error = list[Slip](), None, 0.0
    for name, title, usual, half_range in _unlikely(model):
        if base is None:
            runs = runs_of(model)
            base = minimise(runs, (), {}, runs.no_own)
            error = runs.worst(base)
        other = with_values(model, {name: usual})
        runs = runs_of(other)
        error_after = runs.worst(minimise(runs, (), {}, runs.no_own))
        if error_after < SLIP * error:
            slips.append(Slip(name, title, values_of(model)[name], usual, half_range, error, error_after))
            model, error = other, error_after
    return model, tuple(slips), base if slips else None


def _unlikely(model: Model) -> Iterator[tuple[str, str, float, float]]:
    """Numbers that hardly any ship has, the titles of their groups, what is usual, and half of the usual range."""
    for group in stated_groups(model):
        for name, usual in group.unlikely.items():
            yield name, group.title, usual, group.scope[name].half_usual


def with_findings(findings: Sequence[Finding], slips: Sequence[Slip], rest: Mapping[str, float]) -> list[Finding]:
    """The findings with these numbers among those of the model.

    rest : number of the model -> its value after the fit.
    """
    if not slips:
        return list(findings)
    own = next((f for f in findings if f.cause == BaseCoefficients.id), None)
    first = own or Finding(BaseCoefficients.id, (), BY_FREE_RUNS, None, None, (), details={}, evidence="")
    names = {size.parameter for size in first.sizes}
    new = [s for s in slips if s.name not in names]
    sizes = tuple(Size(s.name, x := rest[s.name], x - s.half_range, x + s.half_range, "1") for s in new)
    titles = list(dict.fromkeys([*(s.title for s in slips), *first.details.get("groups", ())]))
    said = "; ".join([*(s.evidence for s in slips), *filter(None, [first.evidence])])
    whole = replace(first, sizes=(*sizes, *first.sizes), details={**first.details, "groups": titles}, evidence=said)
    return [whole, *(f for f in findings if f is not own)]
