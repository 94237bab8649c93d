"""What is told of forces that describe what remains: sizes, readings, the extended model, the verdict.

A force that follows a motion is a term of the extended model, unless it worsens held-out records; one in time, and a
sensor that drifts, where held-out records show it too.  Section 8 of docs/mathematics/pieces.md.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import Size
from ...datasets.axes import goes_astern
from ...datasets.columns import POSITIONS
from ...estimation.selection.selection import Selection, is_enough, mean_squares
from ...models.extend import extended
from ...models.instruments import combined
from ..causes.base import Cause
from ..causes.registry import causes
from ..causes.steering_gear import own_neutral_angles
from ..gain.guard import CLEARLY, log_fall, training_errors, worsens
from ..gain.runs import with_runs
from ..report.bank import without_causes
from ..result import RemainingForce
from .answer import extended_model
from .curve import curve_of
from .force_search import enough_of
from .forces import AXES, BODY, READINGS, drift_of, reading_of, unit_of
from .search import Choice, half_intervals, interval_factor

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.selection import Entered
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis
    from .events import Event
    from .force_search import Beside, Remainder
    from .forces import Force

FAINTEST = 1e-4
"""Share of the squared motion below which no share of what remains is told: the errors are those of the sensors."""
BIASES = {"r": ("yaw_rate_bias", "yaw_rate_bias"), "v": ("sway_offset", "sway_bias")}
"""State that a drifting sensor shows -> cause and instrument of its steady error, whose place the drift takes."""
INSTEAD = "what remains is described without it"
ASTERN = 0.05
"""Share of the largest speed of a record from which a craft that goes astern is said to."""
TAKEN_OFF, MOST_OF_IT = 0.5, 0.8
"""Share of what remains of the squared error that forces have to take off: less is no description of it;
share that forces in time and events have to take off, as gusts are none, and from which events are not looked for."""


def with_forces(
    before: Diagnosis,
    diagnosis: Diagnosis,
    start: Model,
    rest: Remainder,
    records: Prepared,
    held_out: Sequence[Record],
    options: Options,
) -> Diagnosis:
    """The diagnosis with forces that were selected; the one before where these worsen held-out records."""
    diagnosis = _without_biases(diagnosis, {rest.forces.forces[c.id].axis for c in rest.selection.candidates})
    share = rest.runs.share_taken(rest.selection.base, rest.selection.final)
    entered = [(c, rest.forces.forces[c.id]) for c in rest.selection.candidates]
    in_time = any("time" in force.shape.depends_on for _, force in entered)
    if share < (MOST_OF_IT if in_time else TAKEN_OFF):
        return before
    of_every_record = any(force.begins or drift_of(rest.runs.places, c) for c, force in entered)
    to_return = of_every_record and bool(held_out) and is_enough(rest.runs, rest.selection.base, enough_of(rest.runs))
    for time_too in (True, False) if in_time and not to_return else (True,):
        plain = _extended_diagnosis(diagnosis, start, rest, time_too, records, held_out, options)
        if not _errs_more(before, plain, in_time and time_too):
            break
    else:
        return before
    if not any(force.extended for force in plain.remaining) and _held_out_fall(before) >= CLEARLY:
        plain = replace(before, remaining=plain.remaining, hypothesis=None)  # forces in no model leave it as it is
    remaining = plain.remaining
    if plain.causes and plain.verdict not in ("unexplained", "partly_named"):
        return plain
    of_sensor = all(force.of_sensor for force in remaining)
    first = (
        "a sensor explains what remains" if of_sensor else "no known cause explains what remains, but it is described"
    )
    said = f"{first}: {remaining[0].text}"
    beside_names = plain.verdict == "partly_named" and plain.causes
    without = plain if beside_names else without_causes(plain, of_hull(plain), INSTEAD)
    return replace(without, verdict="partly_named" if beside_names else "described", reason=said)


def _extended_diagnosis(
    diagnosis: Diagnosis,
    start: Model,
    rest: Remainder,
    time_too: bool,
    records: Prepared,
    held_out: Sequence[Record],
    options: Options,
) -> Diagnosis:
    """The diagnosis with forces, and with a model extended by them; time_too : also by forces in time."""

    def extends(one: Entered, force: Force) -> bool:
        in_model = bool(force.extensions or drift_of(rest.runs.places, one.candidate))
        return in_model and (time_too or "time" not in force.shape.depends_on)

    entered = [(one, rest.forces.forces[one.candidate.id]) for one in rest.selection.entered]
    remaining = tuple(_force(rest, one, extends(one, force)) for one, force in entered)
    own = [one for one, force in entered if extends(one, force)]
    model = _extended_model(start, rest, own) if own else start
    drifts = {n: x for one in own for n, x in _instruments(rest, one).items()}
    model = replace(model, instruments=combined(diagnosis.extended.instruments, drifts))
    return with_runs(
        replace(diagnosis, extended=model, traces=(), remaining=remaining, hypothesis=None),
        records.train, records.instruments, held_out, options.channels,
    )  # fmt: skip


def _errs_more(before: Diagnosis, after: Diagnosis, in_time: bool) -> bool:
    """Whether the extended model predicts held-out records worse than the base model does, or than that of the
    diagnosis before, or the training ones no better.

    Along the measured motion a force can hold a simulation to it, as an observer does: only a simulation with the force
    shows whether it is one.  A record's own trim takes the place of the steady part of a force: held-out records that
    are predicted clearly better without it stand for the force, too.  in_time : a force in time is a term of the model,
    which it is only where it returns: where held-out records are predicted clearly better with it.
    """
    if not any(force.extended for force in after.remaining):
        return False
    instead = len(after.causes) < len(before.causes)
    gain = before.calibrated_gain if instead and before.calibrated_gain else before.gain
    of_held_out = {c: (g.own_after, g.rmse_after) for c, g in gain.items()}
    of_training = {c: error for c, (_, error) in training_errors(before).items()}
    old = {c: of_held_out.get(c, (g.own_before, g.rmse_before)) for c, g in after.gain.items()}
    held_out = log_fall(*_motion({c: (old[c][0], g.own_after) for c, g in after.gain.items()}))
    blind = log_fall(*_motion({c: (old[c][1], g.rmse_after) for c, g in after.gain.items()}))
    train = _motion({c: (of_training.get(c, old), new) for c, (old, new) in training_errors(after).items()})
    if worsens(after) or log_fall(*train) <= 0.0 or (held_out < 0.0 and blind < CLEARLY):
        return True
    least = CLEARLY if own_neutral_angles(before.causes) else -CLEARLY
    if instead and blind < least:
        return True
    by_force = _held_out_fall(after) if instead else held_out
    return in_time and by_force < CLEARLY


def _held_out_fall(diagnosis: Diagnosis) -> float:
    """Fall of the logarithm of the error of held-out records from the base model to the extended one, each record with
    its own trim; 0 without these."""
    return log_fall(*_motion({c: (g.own_before, g.own_after) for c, g in diagnosis.gain.items()}))


def _motion(errors: Mapping[str, tuple[float, float]]) -> list[dict[str, float]]:
    """Errors before and after of channels but positions, which repeat what the others show."""
    return [{c: pair[i] for c, pair in errors.items() if c not in POSITIONS} for i in (0, 1)]


def _instruments(rest: Remainder, one: Entered) -> dict[str, float]:
    """Error and drift of a sensor that all records have, as instruments of a model; none of a force."""
    names = drift_of(rest.runs.places, one.candidate)
    return {instrument: rest.fitted.value(name) for name, instrument in names.items()}


def _force(rest: Remainder, one: Entered, extends: bool) -> RemainingForce:
    force, runs = rest.forces.forces[one.candidate.id], rest.runs
    share = runs.share_taken(rest.selection.base, rest.selection.final) if len(rest.selection.entered) == 1 else None
    fits = rest.selection.base, rest.selection.final
    gain = _gain(runs, *(mean_squares(runs, f.left_out) for f in fits))
    said = force.text
    if share is not None and np.sum(runs.excess(rest.selection.base)) > FAINTEST:
        said += f"; it takes {100.0 * share:.0f} % off the squared error of left-out pieces"
    reading, following = reading_of(force)
    sizes = tuple(_sizes(rest, one))
    rivals = tuple(rest.forces.forces[c.id].text for c in one.tied_with)
    axis = BODY.get(force.axis, force.axis)
    return RemainingForce(
        axis, force.shape.depends_on, said, share, gain, sizes, extends, reading, following,
        rivals, curve_of(force, runs, sizes),
    )  # fmt: skip


def _gain(runs: FreeRuns, before: np.ndarray, after: np.ndarray) -> dict[str, tuple[float, float]]:
    """Channel -> root mean square errors of mean squares (C,) before and after."""
    pairs = zip(np.sqrt(before).tolist(), np.sqrt(after).tolist(), strict=True)
    return dict(zip(runs.channels, pairs, strict=True))


def event_forces(now: Beside, of_pieces: Sequence[Event]) -> tuple[RemainingForce, ...]:
    """Events as forces that are in no model."""
    runs, fitted = now.runs, now.plain
    whole = float(np.sum(runs.excess(fitted))) or 1.0
    out = []
    for event in of_pieces:
        taken = np.sum(mean_squares(runs, (event.before - event.after)[None]) / runs.motion**2)
        count = np.maximum(runs.counts[event.unit], 1.0)
        gain = _gain(runs, event.before / count, event.after / count)
        half = interval_factor(runs) * event.sd
        size = Size(f"{event.axis}_event", event.size, event.size - half, event.size + half,
                    unit_of(event.axis, runs.model), event.record)  # fmt: skip
        said = f"a {AXES[event.axis]} that acts for a time: {event.record}, {event.begin_s:.0f} to {event.end_s:.0f} s"
        astern = is_astern(runs.units[event.unit].record, event)
        said += ", while she goes astern" if astern else ""
        axis, share = BODY.get(event.axis, event.axis), float(np.clip(taken / whole, 0.0, 1.0))
        reading = READINGS["astern" if astern else "event"]
        out.append(RemainingForce(axis, ("time",), said, share, gain, (size,), False, *reading))
    return tuple(out)


def is_astern(record: Record, event: Event) -> bool:
    """Whether the craft goes astern for most of the time of an event, as far as that is measured."""
    if not record.has("surge_m_s"):
        return False
    first, end = np.searchsorted(record.time_s - record.time_s[0], [event.begin_s, event.end_s])
    fastest = float(np.nanmax(np.abs(record.column("surge_m_s"))))
    return goes_astern(record.slice(int(first), int(max(end, first + 1))), ASTERN * fastest)


def _sizes(rest: Remainder, one: Entered) -> Iterator[Size]:
    """Sizes of a force's numbers with 90 % intervals."""
    halves = half_intervals(rest.runs, rest.fitted)
    force = rest.forces.forces[one.candidate.id]
    for name in one.candidate.names:
        value, half, number = rest.fitted.value(name), halves[name], rest.runs.places[name].record
        parameter = name.partition("@")[0].partition(":")[0]
        unit, record = force.unit(name, rest.runs.model), rest.runs.record_names.get(number)
        yield Size(parameter, value, value - half, value + half, unit, record)


def _extended_model(start: Model, rest: Remainder, entered: Sequence[Entered]) -> Model:
    """The model with the forces that follow its motion, and with its own numbers where these moved."""
    choice = Choice(rest.runs, Selection(rest.selection.base, (), rest.fitted))
    out = extended_model(start, choice, {})
    for one in entered:
        force = rest.forces.forces[one.candidate.id]
        for extension, values in force.parameters({n: rest.fitted.value(n) for n in one.candidate.names}):
            out = extended(out, extension, values)
    return out


def share_of(diagnosis: Diagnosis) -> float:
    """Share of the error that forces take off together; 1 where only several together do."""
    return max((1.0 if force.share is None else force.share for force in diagnosis.remaining), default=0.0)


def of_hull(diagnosis: Diagnosis) -> set[str]:
    """Causes (ids) that describe the hull, of those that are named."""
    entries = {f.cause: causes().get(f.cause) for f in diagnosis.causes}
    return {name for name, entry in entries.items() if isinstance(entry, Cause) and entry.describes_hull}


def _without_biases(diagnosis: Diagnosis, axes: Collection[str]) -> Diagnosis:
    """The diagnosis without steady errors of sensors that drift."""
    ids, names = ({pair[i] for axis, pair in BIASES.items() if axis in axes} for i in (0, 1))
    return without_instruments(diagnosis, ids, names)


def without_instruments(diagnosis: Diagnosis, ids: Collection[str], instruments: Collection[str]) -> Diagnosis:
    """The diagnosis without some causes, and without some instruments of its extended model."""
    others = {name: x for name, x in diagnosis.extended.instruments.items() if name not in instruments}
    rest = without_causes(diagnosis, {*ids}, INSTEAD)
    return replace(rest, extended=replace(diagnosis.extended, instruments=others))
