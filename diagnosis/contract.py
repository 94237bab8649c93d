"""What every cause has to keep to, as checks that third parties can run on their own causes.

    from helmbench.diagnosis.contract import check_cause

    def test_my_cause():
        check_cause(MyCause)

A check raises AssertionError with a sentence.  Causes that no vessel of the checks can carry are refused as well.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..checks.base import Check
from ..datasets.generator import Case, generate
from ..datasets.instruments import corrected, observed
from ..datasets.record import Record
from ..estimation.filters.innovations.derivatives import columns
from ..estimation.filters.innovations.estimator import Estimator, estimator
from ..estimation.filters.innovations.settings import Setting
from ..estimation.filters.innovations.vector import SYMBOLS
from ..estimation.records.series import series_of
from ..models.families.extensions import extension_of, is_made_up
from ..models.model import CHANNELS, Model, model_to_json, resolve
from ..models.simulate import simulate
from .causes.base import WHERE, Cause, NotTestable, StageCause
from .innovations.as_model import extended_model
from .innovations.searches import Search
from .innovations.state import Variant, first_state

SECOND = "kvlcc2-l7"
VESSELS = ("mariner", SECOND, "response-1", "nomoto-1")
"""Models that the checks try a cause on, two of 3-DOF; the last one with a response model's coefficients."""
SIGMAS = 30.0
"""Size, in standard errors, at which effects are switched on."""
CLOSE, SHARE, ROUNDING = 0.05, 0.4, 1e-5
"""Largest difference of the extended model's run from the filter's: in standard deviations of the base model's run, and
on the channel that the effect changes most as a share of that change."""


class Carried(NamedTuple):
    """A cause on a model that can carry it: the filter on noisy records, that on records without noise, these records,
    and the cause's variants."""

    est: Estimator
    exact: Estimator
    records: tuple[Record, ...]
    variants: tuple[Variant, ...]


@lru_cache(maxsize=32)
def _filter(
    vessel: str, terms: tuple[str, ...], commanded: bool, noise: str = "low"
) -> tuple[Estimator, tuple[Record, ...]]:
    """A vessel's filter on two records with every channel and, if asked for, the rudder's command only."""
    source = resolve("response-1" if vessel == "nomoto-1" else vessel)
    model = resolve(vessel)
    if not model.known:
        values = {"T": source.parameters["T"], "K": source.parameters["K"]}
        model = model.with_coefficients(model.from_parameters(values))
    texts = source.suite["train"]
    records = [generate(Case(source.id, texts[i % len(texts)], noise, seed=i, duration_s=200.0)) for i in range(2)]
    if commanded:
        records = [r.with_channels(rudder_command_rad=r.rudder(), rudder_rad=None) for r in records]
    return estimator(model, records, terms=terms if model.is_3dof else ()), tuple(records)


def carried(cls: type[Cause]) -> Iterator[Carried]:
    """The models of VESSELS that can carry the cause, measured and commanded rudder.

    A product term needs a filter of its own, which has to be compiled: one 3-DOF model is enough.
    """
    cause = cls()
    terms = (cause.extension,) if cause.extension is not None and is_made_up(cause.extension) else ()
    vessels = [name for name in VESSELS if name != SECOND] if terms else VESSELS
    for commanded in (False, True):
        for vessel in vessels:
            est, _ = _filter(vessel, terms, commanded)
            try:
                variants = tuple(cause.variants(est))
            except NotTestable:
                continue
            exact, records = _filter(vessel, terms, commanded, "none")
            yield Carried(est, exact, records, variants)


def _one_of_each_kind(cls: type[Cause]) -> Iterator[Carried]:
    """The first 3-DOF model and the first response model that can carry the cause."""
    seen = set()
    for case in carried(cls):
        if case.est.model.is_3dof not in seen:
            seen.add(case.est.model.is_3dof)
            yield case


def switched_on(case: Carried, variant: Variant) -> Setting:
    """The start with every parameter of a variant at SIGMAS standard errors, or a small change, inside its bounds."""
    est = case.est
    s = est.start()
    for p, column in zip(variant, columns(est, s, variant) if variant else (), strict=True):
        size = np.linalg.norm(column)
        amount = SIGMAS / size if size > 0.0 else p.scale
        s = est.at(s, p, float(np.clip(amount, p.low + 0.1 * p.scale, p.high - 0.1 * p.scale)))
    return s


def check_is_described(cls: type[Check]) -> None:
    """Identifier, physics, unit, place and search are stated."""
    cause = cls()
    assert cause.id.isidentifier() and cause.id == cause.id.lower(), f"{cause.id!r} is no identifier in small letters"
    assert len(cause.physics.split()) >= 5, "the docstring does not say what the cause is"
    assert cause.where in (*WHERE, "record"), f"where is {cause.where!r}, one of {', '.join(WHERE)}"
    assert cause.unit, "the unit of the sizes is not stated"
    if not isinstance(cause, Cause):
        return
    if not isinstance(cause, StageCause):
        assert isinstance(cause.search, Search), "the search is not stated"
        own = cause.number is not None or type(cause).variants is not Cause.variants
        assert own or cause.search.entries, "neither a number that it moves nor variants are stated"
    if cause.extension is not None:
        extension_of(cause.extension)


def check_some_model_carries_it(cls: type[Cause]) -> None:
    """At least one model carries it, and what cannot says why."""
    assert any(True for _ in carried(cls)), "no model of the checks can carry the cause"
    for commanded in (False, True):
        for vessel in VESSELS:
            try:
                cls().variants(_filter(vessel, (), commanded)[0])
            except NotTestable as reason:
                assert len(str(reason).split()) >= 3, f"the reason {str(reason)!r} says too little"
            except KeyError:
                assert cls.extension is not None and is_made_up(cls.extension), "an entry of the vector does not exist"


def check_parameters_are_zero_where_it_is_absent(cls: type[Cause]) -> None:
    """At the start every parameter is zero, lies in its bounds, and returns to the start when it is set to zero."""
    for case in carried(cls):
        est = case.est
        start = est.start()
        for variant in case.variants:
            s = switched_on(case, variant)
            for p in variant:
                assert p.unit, f"parameter {p.name} has no unit"
                assert est.value(start, p) == 0.0, f"parameter {p.name} is not zero where the cause is absent"
                assert p.low <= est.value(s, p) <= p.high, f"parameter {p.name} leaves its bounds"
                s = est.at(s, p, 0.0)
            same = [p for p in variant if p.low <= 0.0 <= p.high]
            if len(same) == len(variant):
                assert np.allclose(s.vectors, start.vectors, rtol=1e-9, atol=1e-12), "zero does not restore the model"


def check_it_changes_what_is_measured(cls: type[Cause]) -> None:
    """The likelihood changes when the cause is switched on; a cause without parameters offers a search of its own."""
    for case in carried(cls):
        calm = case.est.evaluate(case.est.start()).log_likelihood
        for variant in case.variants:
            if variant:
                there = case.est.evaluate(switched_on(case, variant)).log_likelihood
                assert there != calm, "switching the cause on changes nothing"
            else:
                assert type(cls.search).attempt is not Search.attempt, "no parameters, and no search of its own"


def check_sizes(cls: type[Cause]) -> None:
    """Sizes are finite, inside their intervals, with a unit."""
    rng = np.random.default_rng(3)
    for case in carried(cls):
        for variant in (v for v in case.variants if v):
            s, k = switched_on(case, variant), len(variant)
            spread = np.diag([(0.1 * case.est.value(s, p)) ** 2 for p in variant])
            sizes = cls().sizes(case.est, s, variant, spread, rng)
            assert sizes, "no size is stated"
            for size in sizes:
                assert np.isfinite([size.value, size.low, size.high]).all(), f"{size.parameter} is not finite"
                assert size.low <= size.value <= size.high and size.unit, f"{size.parameter}: interval or unit"
            assert len(sizes) <= 2 * k, "more sizes than numbers"


def check_extended_model_is_what_was_fitted(cls: type[Cause]) -> None:
    """The extended model, written and read back, simulates corrected records as the filter does at the setting.

    Where a quantity belongs to a record, the model holds the mean over the records.  One 3-DOF model and one response
    model are enough: every extended family has to be compiled.
    """
    for case in _one_of_each_kind(cls):
        for variant in (v for v in case.variants if v):
            s = _mean(case, switched_on(case, variant))
            model = extended_model(case.est, s, [cls()])
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "extended.json"
                model_to_json(model, path)
                reloaded = resolve(path)
            assert np.array_equal(reloaded.coefficients, model.coefficients), "coefficients change on reading back"
            assert dict(reloaded.instruments) == dict(model.instruments), "instruments change on reading back"
            _same_simulation(case, s, replace(reloaded, id=model.id))


def _mean(case: Carried, s: Setting) -> Setting:
    return replace(s, vectors=np.tile(s.vectors.mean(axis=0), (len(s.vectors), 1)))


def _same_simulation(case: Carried, s: Setting, model: Model) -> None:
    """Free runs of the base model's filter at the setting, and of the extended model on corrected records.

    The records have no noise: both start from the same state.
    """
    est = case.exact
    free = 0 if model.is_3dof else 3
    records = [corrected(r, model.instruments) for r in case.records]
    simulated = _simulated if model.is_3dof else _filtered
    here, calm = replace(est.start(), vectors=s.vectors), est.start()
    for i, (record, theirs) in enumerate(zip(case.records, simulated(model, records, free), strict=True)):
        ours, base = est.free_run(here, i, free), est.free_run(calm, i, free)
        of_sensors = _shown(theirs, record, model)
        error, effect = _relative(ours - of_sensors, base, est, free), _relative(ours - base, base, est, free)
        worst, largest = int(np.argmax(error)), int(np.argmax(effect))
        close = error[worst] < CLOSE and error[largest] <= SHARE * effect[largest] + ROUNDING
        assert close, f"the extended model simulates channels otherwise than the filter ({error[worst]:.3f})"


def _relative(difference: np.ndarray, base: np.ndarray, est: Estimator, free: int) -> np.ndarray:
    """Root mean square of a difference (T, 6) of runs, for each measured channel in standard deviations of the base."""
    scale = np.maximum(np.nanstd(base[free:, est.channels], axis=0), 1e-9)
    return np.sqrt(np.nanmean(difference[free:, est.channels] ** 2, axis=0)) / scale


def _simulated(model: Model, records: Sequence[Record], free: int) -> Iterator[np.ndarray]:
    """Channels (T, 6) of a 3-DOF model, simulated along the records: its filter need not be compiled."""
    for record in records:
        series = series_of(record, model, SYMBOLS)
        states = simulate(model, series.inputs, series.dt, series.start)
        out = np.full((len(series.outputs), len(SYMBOLS)), np.nan)
        places = [SYMBOLS.index(model.states[i]) for i in series.columns]
        out[:, places] = series.observe(states[:, series.columns])
        yield out


def _filtered(model: Model, records: Sequence[Record], free: int) -> Iterator[np.ndarray]:
    """Channels (T, 6) of a response model by its own filter, which knows the speed that a speed loss takes off."""
    est = estimator(model, records)
    yield from (est.free_run(est.start(), i, free) for i in range(len(records)))


def _shown(predicted: np.ndarray, record: Record, model: Model) -> np.ndarray:
    """Channels (T, 6) that the model's sensors show of its free run."""
    names = [CHANNELS[symbol] for symbol in SYMBOLS]
    held = {name: predicted[:, c] for c, name in enumerate(names) if np.isfinite(predicted[:, c]).all()}
    seen = observed(Record(record.time_s, held, record.name), model.instruments)
    out = predicted.copy()
    for c, name in enumerate(names):
        if name in held:
            out[:, c] = seen.column(name)
    return out


def check_pickles(cls: type[Cause]) -> None:
    """Causes go to other processes and are the same there; two of a kind are equal."""
    assert pickle.loads(pickle.dumps(cls())) == cls() and hash(cls()) == hash(cls())
    state = next(iter(carried(cls)), None)
    if state is not None:
        bank = {cls(): state.variants}
        assert first_state(state.est, bank, 0.01, (), None).bank[cls()] == state.variants


CHECKS: tuple[Callable[[type[Cause]], None], ...] = tuple(
    value for name, value in list(globals().items()) if name.startswith("check_")
)
"""Every check of this module, in order."""
OF_STAGES = (check_is_described,)
"""The checks of causes that stages of their own look for: they do not act in the filter."""


def check_cause(cls: type[Cause]) -> None:
    """Run all checks on a cause class; the first that fails raises AssertionError."""
    for check in OF_STAGES if not issubclass(cls, Cause) or issubclass(cls, StageCause) else CHECKS:
        check(cls)
