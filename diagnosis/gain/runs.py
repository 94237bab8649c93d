"""What the models of a diagnosis gain: free runs of each and of the base model along the records as they were read.

The runs are those of every command (`estimation/run`): the base model's error on a record is the same number as by
`validate`.  An extended model has what was corrected in the records as its instruments.  What belongs to a held-out
record (its current, its wind) is estimated on its first part and stated.

A trial's own neutral rudder angle and start belong to the trial, not to the model: half a degree of neutral angle is
ten degrees of heading after a zigzag.  Both are fitted along the record itself, under the priors that calibrations have
(section 1 of docs/mathematics/calibration.md, without numbers of the model): what remains is the model's error.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.instruments import RATE_LIMIT
from ...datasets.signals import sensor_sd
from ...estimation.records.gaps import clock_of
from ...estimation.records.naming import named
from ...estimation.results.fit import arithmetic_guard
from ...estimation.run.run import run_along, squares_of
from ...estimation.selection.minimiser import minimise
from ...estimation.validation.validate import validate
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.time_scale import time_scale_s
from ..free_runs.bank import of_numbers
from ..free_runs.problem import FreeRuns
from ..free_runs.units import started_states, whole_unit
from ..report.verdict import where
from ..result import Gain, Trace

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.run.run import Run
    from ...estimation.run.stretch import FreeRun, Stretch
    from ...models.model import Model
    from ..result import Diagnosis

BLOCK_S = 20.0
"""Length of a block, s of a 160 m ship: errors of different blocks count as independent."""
DRAWS = 1000
EXTENDED = "extended model"


class Pair(NamedTuple):
    """The runs of two models along a record, both also with the record's own neutral rudder angle and start.

    block : samples of a block of BLOCK_S, s of a 160 m ship: errors of different blocks count as independent.
    """

    before: Run
    after: Run
    own_before: Run
    own_after: Run
    block: int

    def without(self, channels: Collection[str]) -> Pair:
        """The pair without some channels."""
        kept = {c: values for c, values in self.before.predicted.items() if c not in channels}
        return self._replace(before=replace(self.before, predicted=kept))

    @property
    def channels(self) -> list[str]:
        """Channels that both models predict."""
        return _shared(self.before, self.after)


def with_runs(
    diagnosis: Diagnosis,
    train: Sequence[Record],
    corrected: Collection[str],
    held_out: Sequence[Record],
    channels: Sequence[str] | None = None,
) -> Diagnosis:
    """The diagnosis with the gain of its models on held-out records, and with the runs that a page shows.

    train : as they were corrected, of the instruments `corrected` and of faults of their files.  held_out :
    as they were read.  channels : the only ones that are told; None: all.
    """
    base, extended = (
        without_instruments(one, {*diagnosis.model.instruments, *corrected})
        for one in (diagnosis.model, diagnosis.extended)
    )
    held = pairs_of(diagnosis.model, diagnosis.extended, held_out, diagnosis.of_held_out, channels)
    traces = [
        trace_of(pair.before, pair.after, "train") for pair in pairs_of(base, extended, train, {}, channels, own=False)
    ]
    return replace(
        diagnosis,
        gain=gain_of(held, np.random.default_rng(diagnosis.seed)),
        traces=(*traces, *(trace_of(pair.before, pair.after, "held_out") for pair in held)),
        where=tuple(where(traces)),
    )


def with_calibrated(
    diagnosis: Diagnosis, calibrated: Model, held_out: Sequence[Record], channels: Sequence[str] | None = None
) -> Diagnosis:
    """The diagnosis with a calibrated model and its gain on held-out records, as `with_runs` has them."""
    pairs = pairs_of(diagnosis.model, calibrated, held_out, diagnosis.of_held_out, channels)
    return replace(
        diagnosis, calibrated=calibrated, calibrated_gain=gain_of(pairs, np.random.default_rng(diagnosis.seed))
    )


def pairs_of(
    base: Model,
    model: Model,
    records: Sequence[Record],
    of_record: Mapping[str, Mapping[str, float]],
    channels: Sequence[str] | None = None,
    own: bool = True,
) -> list[Pair]:
    """Runs along the records that both models can be run along.

    of_record : name of a record -> values of coefficients of `model` that belong to it.  own : whether runs with the
    record's own neutral angle and start are wanted; otherwise these are the plain ones.
    """
    out = []
    for record in records:
        after = _with(model, of_record.get(record.name, {}))
        try:
            plain = [run_along(one, record) for one in (base, after)]
            trimmed = [run_along(one, record, by=own_run) for one in (base, after)] if own else plain
        except CannotFit:
            continue
        block = max(1, round(BLOCK_S * clock_of(base, [record]) / record.dt))
        pair = Pair(plain[0], plain[1], trimmed[0], trimmed[1], block)
        out.append(pair if channels is None else pair.without({*plain[0].predicted} - {*channels}))
    return out


def without_instruments(model: Model, instruments: Collection[str]) -> Model:
    """The model without some of its instruments, which its records are behind; without its gear where these limit the
    rudder's rate."""
    kept = {name: value for name, value in model.instruments.items() if name not in instruments}
    gear = replace(model.rudder, rate_rad_s=np.inf) if RATE_LIMIT in model.instruments.keys() - kept else model.rudder
    return replace(model, instruments=kept, rudder=gear)


def _with(model: Model, values: Mapping[str, float]) -> Model:
    """The model with the coefficients that it has of some values."""
    names = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    return model.with_coefficients([values.get(name, own) for name, own in names.items()])


def gain_of(pairs: Sequence[Pair], rng: np.random.Generator) -> dict[str, Gain]:
    """Gain of every channel over the records, with a block-bootstrap interval of the ratio."""
    runs = [list(column) for column in zip(*(pair[:4] for pair in pairs), strict=True)]
    sums = [squares_of(one) for one in runs]
    channels = dict.fromkeys(c for pair in pairs for c in pair.channels)
    return {c: _gain(c, pairs, [own[c].scores() for own in sums], rng) for c in channels}


def _gain(channel: str, pairs: Sequence[Pair], scores: Sequence[tuple[float, float]], rng: np.random.Generator) -> Gain:
    """scores : root mean square error and R^2 of the four runs of all pairs."""
    (old, r2_old), (new, r2_new), (own_old, _), (own_new, _) = scores
    blocks = [_blocks(pair, channel) for pair in pairs if channel in pair.channels]
    before, after = (np.concatenate(side) for side in zip(*blocks, strict=True))
    _, low, high = ratio_of(before, after, rng)
    floor = np.mean([sensor_sd(p.before.measured.channels[channel]) ** 2 for p in pairs if channel in p.channels])
    gap = old**2 - floor
    closed = (old**2 - new**2) / gap if gap > 0.0 and old > 1.05 * np.sqrt(floor) else 0.0
    return Gain(old, new, low, high, r2_old, r2_new, float(np.clip(closed, -9.0, 1.0)), own_old, own_new)


def _blocks(pair: Pair, channel: str) -> tuple[np.ndarray, np.ndarray]:
    """Sum of squared errors and number (B, 2) of both runs in blocks."""
    both = zip(pair.before.pairs(channel), pair.after.pairs(channel), strict=True)
    errors = [(seen - run, other - after) for (seen, run), (other, after) in both]
    old, new = ([block for e in side for block in error_blocks(e, pair.block)] for side in zip(*errors, strict=True))
    return np.array(old), np.array(new)


def trace_of(before: Run, after: Run, role: str) -> Trace:
    """A record for the page: measured channels against both runs, in the channels that both predict."""
    own, channels = before.measured, _shared(before, after)
    runs = [{c: run.predicted[c] for c in channels} for run in (before, after)]
    measured = {c: own.channels[c] for c in channels}
    return Trace(own.name, role, own.time_s - own.time_s[0], own.rudder, measured, *runs)


def _shared(before: Run, after: Run) -> list[str]:
    """Channels that both runs predict."""
    return [c for c in before.predicted if c in after.predicted]


def error_blocks(error: np.ndarray, size: int) -> list[tuple[float, int]]:
    """Sum of squares and number of the errors (n,) that are known, of each block of `size`."""
    parts = [error[i : i + size] for i in range(0, error.size, size)]
    return [(float(np.nansum(p**2)), int(np.isfinite(p).sum())) for p in parts]


def ratio_of(old: np.ndarray, new: np.ndarray, rng: np.random.Generator) -> tuple[float, float, float]:
    """Ratio of the rms errors new over old, of blocks (B, 2), with its 90 % interval by a block bootstrap."""
    pick = rng.integers(0, len(old), (DRAWS, len(old)))
    ratios = np.sqrt(new[pick, 0].sum(axis=1) / np.maximum(old[pick, 0].sum(axis=1), 1e-300))
    low, high = np.quantile(ratios, [0.05, 0.95])
    whole = np.sqrt(new[:, 0].sum() / max(old[:, 0].sum(), 1e-300))
    return float(whole), float(low), float(high)


def own_effects(stretch: Stretch) -> tuple[float, np.ndarray]:
    """A neutral rudder angle, rad, and a start (n,) of the stretch's own, fitted to it under their priors.

    Raises
    ------
    CannotFit : the model has no time to scale by, or the stretch has a few samples only.
    """
    length_s = time_scale_s(stretch.model)
    unit = whole_unit(stretch.model, stretch.record, length_s, stretch.begin_s)
    runs = FreeRuns(of_numbers(stretch.model), [unit], length_s, whole=True)
    angle, *changes = minimise(runs, (), {}, runs.no_own).point.own[0].tolist()
    start = unit.start.copy()
    for change, symbol in zip(changes, started_states(stretch.model), strict=True):
        start[stretch.model.states.index(symbol)] += change
    return angle, start


def own_run(stretch: Stretch) -> FreeRun:
    """The free run with the stretch's own neutral rudder angle and start; the plain one where there are none."""
    try:
        angle, start = own_effects(stretch)
    except CannotFit:
        return stretch.free_run()
    inputs = stretch.series.inputs.copy()
    inputs[:, 0] += angle
    return stretch.run(start, inputs)


def with_errors_ahead(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis with errors ahead along the records of its evaluation.

    The extended model stands first.  Without a model that can be run along the records it stays as it is.
    """
    models = {EXTENDED: diagnosis.extended} if diagnosis.extends else {}
    models |= {diagnosis.model.id: diagnosis.model}
    known = {name: model for name, model in models.items() if model.known}
    try:
        with arithmetic_guard():
            ahead = validate(known, named(diagnosis.evaluation)) if known else None
            return replace(diagnosis, ahead=ahead)
    except (BadInput, FitFailed):
        return diagnosis
