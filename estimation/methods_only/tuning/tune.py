"""Tuning a method's options on records by an Optuna study, which several processes or machines may share."""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, Self, cast

from ....models.errors import BadInput, CannotFit, FitFailed
from ...estimates.estimate import Estimate, predictor_of
from ...results.fit import SHORTEST
from ...results.predictor import free_run_error
from .space import Choice, Domain, grid_of

if TYPE_CHECKING:
    from optuna.samplers import BaseSampler
    from optuna.storages import BaseStorage
    from optuna.study import Study
    from optuna.trial import TrialState

    from ....datasets.record import Record
    from ....models.model import Model

TUNERS = ("abc", "tpe", "cmaes", "gp", "grid", "random")
VALIDATIONS = ("split", "held-out")
SHARE = 0.6
"""Share of every record that a split trains on (paper 003, section 4: the first 60 %)."""
FAILURES = (CannotFit, FitFailed, BadInput)
"""Errors of a fit that make a trial fail, but not the study."""


class Tunable(Protocol):
    """What can be tuned: anything with options that `sklearn.base.clone` copies, and a fit."""

    name: ClassVar[str]

    def get_params(self, deep: bool = True) -> dict[str, Any]: ...

    def set_params(self, **options: Any) -> Self: ...

    def fit(self, records: Sequence[Record], model: Model) -> Estimate: ...


class Tuning(NamedTuple):
    """Outcome of a study.

    `options` are the best found and `error` is their validation error.  `trials` is the number of finished trials in
    the study, including those of other processes and of earlier sessions; `failed` of them have no value; `seconds` is
    their total time.
    """

    options: dict[str, Any]
    error: float
    tuner: str
    validation: str
    trials: int
    failed: int
    seconds: float
    study: str


@dataclass(frozen=True)
class TuningSplit:
    """Records to fit, and records whose free runs count in the error, from sample `since` of each on."""

    train: tuple[Record, ...]
    judged: tuple[Record, ...]
    since: tuple[int, ...]

    def error(self, method: Tunable, model: Model) -> float:
        """Error of the method's free runs (`predictor.free_run_error`); raises as `Method.fit`."""
        estimate = method.fit(self.train, model)
        return free_run_error(predictor_of(estimate), self.judged, model, self.since)


def validation_of(records: Sequence[Record], kind: str) -> TuningSplit:
    """Records split for validation.

    'split': the first 60 % of every record are fitted, the rest is compared with a free run from the record's start.
    'held-out': the last record is compared, the others are fitted.

    Raises
    ------
    CannotFit : there are too few records or samples.
    BadInput : another `kind`.
    """
    if kind not in VALIDATIONS:
        raise BadInput(f"unknown validation {kind!r}", hint=f"known: {', '.join(VALIDATIONS)}")
    if kind == "held-out":
        if len(records) < 2:
            raise CannotFit("validation on a held-out record needs at least two records")
        return TuningSplit(tuple(records[:-1]), (records[-1],), (0,))
    since = tuple(int(SHARE * record.n) for record in records)
    if any(record.n - first < SHORTEST or first < SHORTEST for record, first in zip(records, since, strict=True)):
        raise CannotFit("a record is too short to be split for validation")
    train = tuple(record.slice(0, first) for record, first in zip(records, since, strict=True))
    return TuningSplit(train, tuple(records), since)


def tune(
    method: Tunable,
    space: Mapping[str, Domain],
    records: Sequence[Record],
    model: Model,
    *,
    tuner: str = "abc",
    n_trials: int = 40,
    storage: str | None = None,
    seed: int = 0,
    validation: str = "split",
) -> Tuning:
    """Options of the method, within `space`, with the least validation error.

    Parameters
    ----------
    method : its other options are kept; not modified.
    tuner : one of `TUNERS`.
    n_trials : number of finished trials at the end, including those that a stored study already has.
    storage : None (memory), `PATH.journal` (a file that several processes and machines may share) or a database URL
        such as `sqlite:///PATH`.  Calls with the same storage, records and options work on the same study.
    validation : see `validation_of`.

    Raises
    ------
    CannotFit, FitFailed : no trial gave a finite error.
    BadInput : an argument is impossible.
    """
    if not space or n_trials < 1:
        raise BadInput(f"method {method.name} has no options to tune" if not space else f"{n_trials} trials")
    split = validation_of(records, validation)
    sampler = sampler_of(tuner, space, n_trials, seed, shared=storage is not None)
    with quiet():
        from optuna import create_study
        from optuna.trial import TrialState

        study = create_study(
            storage=None if storage is None else storage_of(storage),
            study_name=study_name_of(method, space, records, model, tuner, seed, validation),
            sampler=sampler,
            load_if_exists=True,
        )
        states = TrialState.COMPLETE, TrialState.PRUNED, TrialState.FAIL
        errors = _optimize(study, states, method, space, split, model, n_trials)
        trials: list[Any] = study.get_trials(deepcopy=False, states=states)
    values = [trial for trial in trials if trial.values is not None and math.isfinite(trial.values[0])]
    if not values:
        raise errors[-1] if errors else FitFailed(f"none of {len(trials)} trials has a finite validation error")
    best = min(values, key=lambda trial: (trial.values[0], trial.number))
    return Tuning(
        options=dict(best.params),
        error=float(best.values[0]),
        tuner=tuner,
        validation=validation,
        trials=len(trials),
        failed=sum(trial.values is None for trial in trials),
        seconds=float(sum(trial.duration.total_seconds() for trial in trials if trial.duration is not None)),
        study=study.study_name,
    )


def _optimize(
    study: Study,
    states: tuple[TrialState, ...],
    method: Tunable,
    space: Mapping[str, Domain],
    split: TuningSplit,
    model: Model,
    n_trials: int,
) -> list[Exception]:
    """Run the trials that the study still needs, counting those that ended in `states`; the errors of failed ones."""
    from optuna.study import MaxTrialsCallback
    from sklearn.base import clone

    errors: list[Exception] = []

    def objective(trial: Any) -> float:
        options = {name: domain.suggest(trial, name) for name, domain in space.items()}
        try:
            copy = cast("Tunable", clone(method))
            return split.error(copy.set_params(**options), model)
        except FAILURES as error:
            errors.append(error)
            raise

    left = n_trials - len(study.get_trials(deepcopy=False, states=states))
    if left > 0:
        study.optimize(objective, n_trials=left, callbacks=[MaxTrialsCallback(n_trials, states=states)], catch=FAILURES)
    return errors


def sampler_of(
    tuner: str, space: Mapping[str, Domain], n_trials: int, seed: int | None, shared: bool = False
) -> BaseSampler:
    """The Optuna sampler of a tuner's name.

    Where the study is shared, samplers whose random numbers do not depend on the trial get a new seed, so that two
    machines do not try the same points.

    Raises
    ------
    BadInput : the tuner is unknown, not installed, or cannot search the space.
    """
    from optuna import samplers

    if tuner not in TUNERS:
        raise BadInput(f"unknown tuner {tuner!r}", hint=f"known: {', '.join(TUNERS)}")
    own = None if shared else seed
    if tuner == "abc":
        from .abc import ABCSampler

        return ABCSampler(n_sources=min(10, max(3, n_trials // 8)), seed=seed)
    if tuner == "grid":
        return samplers.GridSampler(grid_of(space, n_trials), seed=seed)
    if tuner == "cmaes" and any(isinstance(domain, Choice) for domain in space.values()):
        raise BadInput("tuner cmaes takes no choices among words", hint="give those options, or use abc or tpe")
    if tuner == "gp" and find_spec("torch") is None:
        raise BadInput("tuner gp needs torch", hint="pip install 'helmbench[gp]'")
    makers = {
        "tpe": samplers.TPESampler,
        "cmaes": samplers.CmaEsSampler,
        "gp": samplers.GPSampler,
        "random": samplers.RandomSampler,
    }
    return makers[tuner](seed=own)


def storage_of(text: str) -> BaseStorage:
    """The storage that a text names: `PATH.journal`, or a database URL.

    Raises
    ------
    BadInput : it is neither, or cannot be opened.
    """
    from optuna.storages import JournalStorage, RDBStorage
    from optuna.storages.journal import JournalFileBackend

    if text.endswith(".journal") and "://" not in text:
        if not Path(text).resolve().parent.is_dir():
            raise BadInput("no such directory", file=Path(text).parent)
        return JournalStorage(JournalFileBackend(text))
    if "://" in text:
        try:
            return RDBStorage(text)
        except Exception as error:  # whatever the database's driver raises
            raise BadInput(f"cannot open it: {str(error).splitlines()[0]}", file=text) from error
    raise BadInput("not a storage of studies", file=text, hint="give PATH.journal or a URL such as sqlite:///PATH")


def study_name_of(
    method: Tunable,
    space: Mapping[str, Domain],
    records: Sequence[Record],
    model: Model,
    tuner: str,
    seed: int,
    validation: str,
) -> str:
    """A name that is the same for equal arguments on every machine, and different for all others."""
    facts = (
        method.get_params(deep=False),
        dict(space),
        model.id,
        model.family,
        model.positive_rudder,
        tuner,
        seed,
        validation,
    )
    digest = hashlib.sha256(repr(facts).encode())
    for record in records:
        digest.update(record.time_s.tobytes())
        for name in sorted(record.channels):
            digest.update(name.encode() + record.channels[name].tobytes())
    return f"{method.name}-{model.family}-{digest.hexdigest()[:16]}"


@contextmanager
def quiet() -> Generator[None]:
    """Without Optuna's log lines and its warnings about experimental features."""
    import optuna

    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        optuna.logging.set_verbosity(before)
