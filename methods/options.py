"""Options of methods, each declared once: name, type, default, meaning, allowed values, and what tuning searches.

    class Huber(Method):
        k: float = option(1.345, "residual from which the loss is linear", POSITIVE, Real(0.3, 3.0, log=True))

`base.Method` makes of a declaration the argument of the constructor, the check before a fit, the line of the docstring
and of `helmbench list methods NAME`, and the range that `tuned:` searches.  A subclass that gives an inherited name a
plain value changes its default; one that declares it again changes what it states.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np

from ..estimation.methods_only.tuning.space import Domain
from ..models.errors import BadInput

SECTION = "Parameters\n----------\n"
_UNSTATED: Any = object()


class Allowed(NamedTuple):
    """Values that an option may have: a test, and what a refusal says is needed."""

    test: Callable[[Any], bool]
    text: str

    def __call__(self, name: str, value: Any) -> None:
        """BadInput unless the option may have the value."""
        if not self.test(value):
            raise BadInput(f"{name} is {value!r}, {self.text} is needed")


def number(text: str, test: Callable[[Any], bool]) -> Allowed:
    """Numbers, neither true nor false, that pass a test."""
    return Allowed(lambda value: isinstance(value, Real) and not isinstance(value, bool) and test(value), text)


def whole(least: int, most: int | None = None) -> Allowed:
    """Whole numbers from `least` on, up to `most` where there is one."""
    text = f"a whole number of at least {least}" if most is None else f"a whole number from {least} to {most}"
    return number(text, lambda value: isinstance(value, Integral) and least <= value and not (most and value > most))


def words(what: str, known: Iterable[str]) -> Callable[[str, Any], object]:
    """A check that a value is one of the known words; `what` they name stands in the refusal."""
    every = tuple(known)

    def check(name: str, value: Any) -> None:
        if value not in every:
            raise BadInput(f"unknown {what} {value!r}", hint=f"known: {', '.join(every)}")

    return check


POSITIVE = number("a positive number", lambda value: value > 0.0)
SWITCH = Allowed(lambda value: isinstance(value, bool | np.bool_), "true or false")
NOT_NEGATIVE = number("a number >= 0", lambda value: value >= 0.0)
SHARE = number("a number above 0 and up to 1", lambda value: 0.0 < value <= 1.0)


@dataclass(frozen=True)
class Option:
    """An option of a method."""

    name: str = ""
    value: Any = _UNSTATED
    """The default."""
    meaning: str = ""
    allowed: Callable[[str, Any], object] | None = None
    """Raises BadInput for a name and an impossible value; not asked about None where that is the default."""
    domain: Domain | None = None
    """What tuning searches."""
    usual: Any = None
    """What a learner takes where no search chooses: see `learner.Learner`."""
    annotation: str = field(default="", compare=False)

    @property
    def default(self) -> str:
        """The default as `make` reads it."""
        return str(self.value).lower() if isinstance(self.value, bool) or self.value is None else str(self.value)

    @property
    def range(self) -> str:
        """The allowed numbers in words; empty where the meaning tells the values."""
        return self.allowed.text if isinstance(self.allowed, Allowed) else ""

    @property
    def searched(self) -> str:
        """The range that tuning searches."""
        return "" if self.domain is None else str(self.domain)

    def texts(self) -> dict[str, str]:
        """What a list of options says, as text."""
        return {name: getattr(self, name) for name in ("name", "default", "meaning", "range", "searched")}

    def check(self, value: Any) -> None:
        """BadInput for an impossible value."""
        if self.allowed is not None and not (value is None and self.value is None):
            self.allowed(self.name, value)

    def after(self, earlier: Option) -> Option:
        """The option with what an inherited declaration states and this one does not."""
        return Option(
            self.name,
            earlier.value if self.value is _UNSTATED else self.value,
            self.meaning or earlier.meaning,
            self.allowed or earlier.allowed,
            self.domain or earlier.domain,
            earlier.usual if self.usual is None else self.usual,
            self.annotation or earlier.annotation,
        )


def option(
    default: Any = _UNSTATED,
    meaning: str = "",
    allowed: Callable[[str, Any], object] | None = None,
    searched: Domain | None = None,
    usual: Any = None,
) -> Any:
    """The declaration of an option in the body of a method's class; what is not stated is inherited."""
    return Option("", default, meaning, allowed or _switch(default), searched, usual)


def _switch(default: Any) -> Allowed | None:
    return SWITCH if isinstance(default, bool) else None


def declared_in(cls: type, inherited: Mapping[str, Option]) -> dict[str, Option]:
    """Name -> declared option of a class: its own in the order of its body, then inherited ones, and `variant` last.

    Replaces declarations in the body by their defaults.
    """
    types, body = inspect.get_annotations(cls), dict(vars(cls))
    own = {
        name: replace(value, name=name, annotation=str(types.get(name, ""))).after(inherited.get(name, Option()))
        for name, value in body.items()
        if isinstance(value, Option)
    }
    for name, one in own.items():
        setattr(cls, name, one.value)
    changed = {name: replace(one, value=body.get(name, one.value)) for name, one in inherited.items()}
    found = own | {name: one for name, one in changed.items() if name not in own}
    return dict(sorted(found.items(), key=lambda item: item[0] == "variant"))


def options_of(cls: Any, declared: Mapping[str, Option]) -> dict[str, Option]:
    """Name -> option of a class's constructor: the declared ones where it takes any by `**`.

    One that the class has of its own has the options that it names.
    """
    _, *parameters = inspect.signature(cls.__init__).parameters.values()
    named = {
        p.name: Option(p.name, p.default, "", _switch(p.default), cls.search_space.get(p.name))
        for p in parameters
        if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)
    }
    found = {name: declared.get(name, one) for name, one in named.items()}
    found |= declared if any(p.kind is p.VAR_KEYWORD for p in parameters) else {}
    stated = vars(cls).get("search_space")
    return found if stated is None else {name: replace(one, domain=stated.get(name)) for name, one in found.items()}


def with_options(text: str, options: Iterable[Option]) -> str:
    """A docstring with the section `Parameters` of these options."""
    entries = [f"{one.name} : {'; '.join(filter(None, (one.range, one.meaning)))}" for one in options if one.meaning]
    lines = (textwrap.fill(entry, 110, subsequent_indent="    ") for entry in entries)
    return f"{inspect.cleandoc(text)}\n\n{SECTION}" + "\n".join(lines) if entries else text


def signature_of(options: Iterable[Option]) -> inspect.Signature:
    """The signature of a constructor with these options."""
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Signature(
        [inspect.Parameter(one.name, kind, default=one.value, annotation=one.annotation) for one in options]
    )
