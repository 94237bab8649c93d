"""A method whose options are tuned within its fit, so that the tuning counts in its time.

    tuned:fw-rls                                       its declared options, 40 trials of the artificial bee colony
    tuned:sklearn:SVR,tuner=tpe,trials=60,epsilon=0.1  an option that is given stays as it is

What is tuned is the method's `search_space` without the options given.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Self

from ...models.errors import BadInput
from ..base import Fit, Method
from ..registry import find
from .tune import TUNERS, VALIDATIONS, storage_of, tune

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from .space import Domain

PREFIX = "tuned:"
STORAGE = "HELMBENCH_STUDIES"
"""Environment variable with the storage of studies, for methods that are not told one; workers inherit it."""


@lru_cache(maxsize=64)
def tuned(text: str) -> type[Tuned]:
    """The method `tuned:text` for a method's identifier, `path.py:Class` or `sklearn:NAME`.

    Raises
    ------
    BadInput : there is no such method, or it has nothing to tune.
    """
    inner = find(text)
    if issubclass(inner, Tuned):
        raise BadInput(f"{text} is tuned already")
    if not inner.search_space:
        raise BadInput(f"method {inner.name} declares no options to tune")
    facts = {
        "name": PREFIX + inner.name,
        "title": f"{inner.title}; options tuned",
        "inner": inner,
        "text": text,
        "variants": inner.variants,
        "order_matters": inner.order_matters,
    }
    return type(f"Tuned{inner.__name__}", (Tuned,), {**facts, "__module__": __name__, "__doc__": Tuned.__doc__})


class Tuned(Method):
    """A method with tuned options; made by `tuned`, which sets the class's name.

    Parameters
    ----------
    tuner : 'abc', 'tpe', 'cmaes', 'gp', 'grid' or 'random'.
    trials : fits that the study ends after.
    validation : 'split' or 'held-out', see `tune.validation_of`.
    tuner_seed : seed of the tuner.
    storage : where the study is kept, see `tune.tune`; default: the environment variable `STORAGE`, else memory.
    Everything else goes to the method, and is not tuned.
    """

    inner: ClassVar[type[Method]]
    text: ClassVar[str]
    own: ClassVar[tuple[str, ...]] = ("tuner", "trials", "validation", "tuner_seed", "storage")

    def __init__(
        self,
        tuner: str = "abc",
        trials: int = 40,
        validation: str = "split",
        tuner_seed: int = 0,
        storage: str | None = None,
        **fixed: Any,
    ) -> None:
        self.tuner, self.trials, self.validation = tuner, trials, validation
        self.tuner_seed, self.storage = tuner_seed, storage
        self.fixed: dict[str, Any] = {}
        self.set_params(**fixed)

    @classmethod
    def option_names(cls) -> list[str]:
        return [*cls.own, *(name for name in cls.inner.option_names() if name not in cls.own)]

    def get_params(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.own} | self.fixed

    def set_params(self, **options: Any) -> Self:
        others = set(self.option_names()) - set(self.own)
        super().set_params(**{name: value for name, value in options.items() if name not in others})
        self.fixed |= {name: value for name, value in options.items() if name in others}
        self.variant = self.fixed.get("variant", self.inner.variant)
        return self

    def __reduce__(self):
        return _remake, (self.text, self.get_params())

    @property
    def space(self) -> dict[str, Domain]:
        """What is tuned: the method's search space without the options given."""
        return {name: domain for name, domain in self.inner.search_space.items() if name not in self.fixed}

    def check_options(self) -> None:
        super().check_options()
        self.inner(**self.fixed).check_options()
        if self.tuner not in TUNERS:
            raise BadInput(f"unknown tuner {self.tuner!r}", hint=f"known: {', '.join(TUNERS)}")
        if self.validation not in VALIDATIONS:
            raise BadInput(f"unknown validation {self.validation!r}", hint=f"known: {', '.join(VALIDATIONS)}")
        if not (isinstance(self.trials, int) and self.trials >= 1):
            raise BadInput(f"trials is {self.trials!r}, a whole number of at least 1 is needed")
        if not self.space:
            raise BadInput(f"every option of {self.inner.name} that could be tuned is given")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        method = self.inner(**self.fixed)
        found = tune(
            method,
            self.space,
            records,
            model,
            tuner=self.tuner,
            n_trials=self.trials,
            storage=self.storage or os.environ.get(STORAGE) or None,
            seed=self.tuner_seed,
            validation=self.validation,
        )
        best = method.set_params(**found.options).fit(records, model)
        return Fit(
            best.coefficients,
            best.covariance,
            best.converged,
            best.message,
            best.n_iterations,
            best.trajectory,
            best.trajectory_time_s,
            extra={**best.extra, "tuning": found.as_dict()},
            predictor=best.predictor,
        )


def _remake(text: str, options: dict[str, Any]) -> Tuned:
    return tuned(text)(**options)


def with_tuner(methods: Sequence[str], tuner: str | None = None, storage: str | None = None) -> tuple[str, ...]:
    """Method texts as `--tuner` and `--storage` of the command line change them.

    With a tuner every method becomes `tuned:`.  A storage alone is for a suite's own tuned methods.  It is
    opened once, so that what is wrong with it shows before anything is run, and handed to this process and its workers
    by the environment variable `STORAGE`.

    Raises
    ------
    BadInput : there is nothing to tune, or the storage cannot be opened.
    """
    texts = tuple(methods)
    if tuner is not None:
        if not texts:
            raise BadInput("--tuner needs the methods to tune", hint="name them with --method")
        texts = tuple(f"{text if text.startswith(PREFIX) else PREFIX + text},tuner={tuner}" for text in texts)
    if storage is not None:
        if texts and not any(text.startswith(PREFIX) for text in texts):
            raise BadInput("--storage is for tuned methods", hint="add --tuner, or --method tuned:...")
        storage_of(storage)
        os.environ[STORAGE] = storage
    return texts
