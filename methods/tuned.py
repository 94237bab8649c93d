"""A method whose options are tuned within its fit, so its computing time includes the tuning.

    tuned:fw-rls                                       its declared options, 40 trials of the artificial bee colony
    tuned:sklearn:SVR,tuner=tpe,trials=60,epsilon=0.1  an option that is given is not tuned

The method's `search_space` is searched, without the options that are given.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, ClassVar, Self

from ..datasets.record import Record
from ..estimation.methods_only.tuning.space import Domain
from ..estimation.methods_only.tuning.tune import TUNERS, VALIDATIONS, storage_of, tune
from ..estimation.results.fit import Fit
from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.model import Model
from .base import Method, Wrapper
from .options import option, whole, words
from .registry import find

PREFIX = "tuned:"
STORAGE = "HELMBENCH_STUDIES"
"""Environment variable with the storage of studies, for methods without the option; worker processes inherit it."""


@lru_cache(maxsize=64)
def tuned(text: str) -> type[TunedMethod]:
    """The method `tuned:text` for a method's identifier, `path.py:Class` or `sklearn:NAME`.

    Raises
    ------
    BadInput : there is no such method, or it declares no options to tune.
    """
    inner = find(text)
    if issubclass(inner, TunedMethod):
        raise BadInput(f"{text} is tuned already")
    if not inner.search_space:
        raise BadInput(f"method {inner.name} declares no options to tune")
    attributes = {
        "name": PREFIX + inner.name,
        "title": f"{inner.title}; options tuned",
        "kind": inner.kind,
        "inner": inner,
        "text": text,
        "variants": inner.variants,
        "order_matters": inner.order_matters,
        "__module__": __name__,
        "search_space": {},
        "wrapped": inner.options,
        "__doc__": TunedMethod.__doc__,
    }
    return type(f"Tuned{inner.__name__}", (TunedMethod,), attributes)


class TunedMethod(Wrapper):
    """A method with tuned options; made by `tuned`, which sets the class's name.  All other options are those of the
    method, and are not tuned."""

    inner: ClassVar[type[Method]]
    text: ClassVar[str]
    tuner: str = option("abc", "'abc', 'tpe', 'cmaes', 'gp', 'grid' or 'random'", words("tuner", TUNERS))
    trials: int = option(40, "number of fits in the study", whole(1))
    validation: str = option(
        "split",
        "'split' or 'held-out', see `helmbench.estimation.methods_only.tuning.tune.validation_of`",
        words("validation", VALIDATIONS),
    )
    tuner_seed: int = option(0, "seed of the tuner", whole(0))
    storage: str | None = option(
        None,
        "where the study is kept, see `helmbench.estimation.methods_only.tuning.tune.tune`; default: the environment "
        "variable `STORAGE`, else memory",
    )

    def set_params(self, **options: Any) -> Self:
        super().set_params(**options)
        self.variant = self.inner_options.get("variant", self.inner.variant)
        return self

    def __reduce__(self):
        return _unpickled, (self.text, self.get_params(deep=False))

    @property
    def space(self) -> dict[str, Domain]:
        """Search space: that of the method without the options given."""
        return {name: domain for name, domain in self.inner.search_space.items() if name not in self.inner_options}

    def check_options(self) -> None:
        super().check_options()
        self.inner(**self.inner_options).check_options()
        if not self.space:
            raise BadInput(f"every option of {self.inner.name} that could be tuned is given")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        method = self.inner(**self.inner_options)
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
        facts: dict[str, Any] = {name: getattr(best, name) for name in Fit._fields if hasattr(best, name)}
        return Fit(**facts)._replace(extra={**best.extra, "tuning": found._asdict()})


def _unpickled(text: str, options: dict[str, Any]) -> TunedMethod:
    return tuned(text)(**options)


@typed
def with_tuner(methods: Sequence[str], tuner: str | None = None, storage: str | None = None) -> tuple[str, ...]:
    """Method texts as `--tuner` and `--storage` of the command line change them.

    With a tuner every method becomes `tuned:`.  A storage without a tuner is for a suite's own tuned methods.  The
    storage is opened once, so that an error in it shows before anything is run, and passed to this process and its
    workers by the environment variable `STORAGE`.

    Raises
    ------
    BadInput : there is no method to tune, or the storage cannot be opened.
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
