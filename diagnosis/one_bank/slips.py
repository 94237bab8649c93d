"""Numbers of a base model that hardly any ship has: a unit or a decimal that was mistaken.

Free runs of such a model are so wrong that no linearisation about it leads back, and the sway that its pieces start
with is wrong, too.  The number is fitted about what is usual, before all else, where free runs err by far less so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from ...checks.result import Size
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.number import Number
from ...models.coefficient_groups import names_of, stated_groups, values_of, with_values
from ..causes.base_coefficients import BaseCoefficients
from ..free_runs.bank import Place
from ..report.bank import BY_FREE_RUNS
from ..report.verdict import of_motion
from ..result import Finding
from .search import half_intervals, neutral_angle

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...estimation.selection.minimiser import Fitted
    from ...models.coefficient_groups import Group
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns

SLIP = 0.5
"""Share of the error of free runs that is left, at most, where what is usual takes the place of a number."""


class Slip(NamedTuple):
    """A number that hardly any ship has, and the one that fits.

    title : of its group.  before, value : as the model states it, and fitted about what is usual.  half : of the 90 %
    interval.  error_before, error_after : of free runs, as shares of the motion.
    """

    name: str
    title: str
    before: float
    value: float
    half: float
    error_before: float
    error_after: float

    @property
    def evidence(self) -> str:
        """In a sentence."""
        before, after = of_motion(self.error_before), of_motion(self.error_after)
        errors = f"free runs err by {before} with the first, by {after} with the second"
        return f"{self.name} is {self.before:.4g}, as hardly any ship has it, and {self.value:.4g} fits: {errors}"


def without_slips(model: Model, runs_of: Callable[[Model], FreeRuns]) -> tuple[Model, tuple[Slip, ...], Fitted | None]:
    """The model with fitted numbers in the place of those that hardly any ship has, where free runs err by far less,
    the one with which they err least first: a wrong centre of gravity makes a right inertia unlikely.  These numbers;
    and the fit of the model as it is, None where there is none.

    runs_of : the free runs of a model.
    """
    slips, base, error = list[Slip](), None, 0.0
    while likely := [*_unlikely(model)]:
        if base is None:
            runs = runs_of(model)
            base = minimise(runs, (), {}, runs.no_own)
            error = runs.worst(base)
        each = [(*_fit_of(group, name, model, runs_of), i) for i, (group, name) in enumerate(likely)]
        least, value, half, i = min(each)
        if least >= SLIP * error:
            break
        group, name = likely[i]
        slips.append(Slip(name, group.title, values_of(model)[name], value, half, error, least))
        model, error = with_values(model, {name: value}), least
    return model, tuple(slips), base if slips else None


def _fit_of(group: Group, name: str, model: Model, runs_of: Callable[[Model], FreeRuns]) -> tuple[float, float, float]:
    """Largest error of free runs with a number fitted about what is usual, as a share of the motion; the number, and
    half of its 90 % interval."""
    scope = group.scope[name]
    runs = runs_of(with_values(model, {name: scope.usual}))
    place = Place("model", column=names_of(runs.model).index(name))
    number = Number(name, scope.half_usual, scope.low - scope.usual, scope.high - scope.usual)
    runs = runs.with_numbers({name: place}, {})
    angle = neutral_angle(runs.bank)  # nearly every rudder has one, and no number of the hull stands for it
    fitted = minimise(runs, [number, *(angle.numbers if angle else ())], {}, runs.no_own)
    return runs.worst(fitted), scope.usual + fitted.value(name), half_intervals(runs, fitted)[name]


def usual(model: Model) -> Model:
    """The model with what is usual in the place of every number that hardly any ship has."""
    return with_values(model, {name: group.scope[name].usual for group, name in _unlikely(model)})


def _unlikely(model: Model) -> Iterator[tuple[Group, str]]:
    """Numbers that hardly any ship has, each with its group."""
    return ((group, name) for group in stated_groups(model) for name in group.unlikely)


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
    sizes = tuple(Size(s.name, x := rest[s.name], x - s.half, x + s.half, "1") for s in new)
    titles = list(dict.fromkeys([*(s.title for s in slips), *first.details.get("groups", ())]))
    said = "; ".join([*(s.evidence for s in slips), *filter(None, [first.evidence])])
    whole = replace(first, sizes=(*sizes, *first.sizes), details={**first.details, "groups": titles}, evidence=said)
    return [whole, *(f for f in findings if f is not own)]
