"""Simulation of one run of a model, and of many: Monte Carlo over coefficients, commands, initial states, gusts and
noise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.memory import require_memory
from .arguments import as_model

if TYPE_CHECKING:
    from ..datasets.disturbances import Disturbance
    from ..datasets.manoeuvres import Manoeuvre
    from ..datasets.many import SimulatedRuns
    from ..datasets.record import Record
    from ..models.model import Model
    from .arguments import Path

Array = np.ndarray[Any, np.dtype[np.float64]]


@typed
def simulate(
    model: Model | Path,
    manoeuvre: str,
    *,
    noise: str = "none",
    disturbance: str = "none",
    seed: int = 0,
    duration_s: float | None = None,
    dt_s: float | None = None,
) -> Record:
    """Simulate a manoeuvre of a model with coefficients, and measure it.

    As `generate`, which takes its texts from a `Case`, but also for a model that was made in Python, such as
    `estimate.model`.

    Parameters
    ----------
    model : a model, or a vessel id or the path of a model.json.
    manoeuvre : for example 'zigzag:20/20' or 'turn:35:port' (`list_manoeuvres`).
    noise : 'none', 'low', 'medium', 'high', 'gross', or channels such as 'yaw_rate=0.05deg_s'.
    disturbance : 'none', or 'wind:12@40deg', 'current:...', 'waves:...', joined by '+'.
    seed : seed of all random numbers, at least 0.
    duration_s : duration, s; None: that of the vessel file.
    dt_s : sampling step, s; None: that of the vessel file.

    Returns
    -------
    The record, with the rudder in the model's sign; the same for the same arguments.

    Raises
    ------
    BadInput : an unknown vessel, a malformed text, a disturbance that the model cannot take, no duration or step, or a
        run that diverges.
    """
    from ..datasets.disturbances import parse_disturbance
    from ..datasets.generator import record_run
    from ..datasets.manoeuvres import KINDS, parse_manoeuvre
    from ..datasets.sensors import parse_noise

    if isinstance(model, str) and model.partition(":")[0] in KINDS:
        raise BadInput(f"{model!r} is a manoeuvre, not a model", hint="first the vessel, then the manoeuvre")
    return record_run(
        as_model(model),
        parse_manoeuvre(manoeuvre),
        parse_noise(noise),
        parse_disturbance(disturbance),
        seed=seed,
        duration_s=duration_s,
        dt_s=dt_s,
    )


@typed
def simulate_many(
    model: Model | Path,
    manoeuvre: str | Sequence[str] | Array,
    runs: int,
    *,
    parameters: Mapping[str, ArrayLike] | None = None,
    coefficients: ArrayLike | None = None,
    initial: Mapping[str, ArrayLike] | None = None,
    noise: str = "none",
    disturbance: str = "none",
    seed: int = 0,
    duration_s: float | None = None,
    dt_s: float | None = None,
    channels: Sequence[str] | None = None,
    every: int = 1,
    indices: Sequence[str] = (),
    jobs: int | None = None,
) -> SimulatedRuns:
    """Simulate many runs of one model at once, several times as fast as one by one.

    Run i is what `simulate` gives for seed + i and its own parameters: noise, gusts and random rudders are the same
    numbers, states agree to 1e-9 of their largest value.  Blocks of 32 runs advance together on each processor.

    Parameters
    ----------
    model : a model with coefficients, or a vessel id or the path of a model.json.
    manoeuvre : a text such as 'zigzag:10/10' (`list_manoeuvres`), or one for each run; or the rudder commands
        themselves, rad in the model's sign, of shape (N,) for all runs or (B, N), a value a sample.
    runs : B, the number of runs.
    parameters : published parameter name -> (B,) values, or one, in the units of the model; the others are the model's.
    coefficients : instead, (B, p) or (p,) in the model's coordinates (`model.coordinates`).
    initial : state name (`model.states`) -> (B,) values, or one, SI and radians; the other states are those of a
        straight course to the north at the model's speed.
    noise, disturbance : as for `simulate`.
    seed : of run 0; run i has seed + i.
    duration_s, dt_s : duration and sampling step, s; None: those that the vessel file suggests, or the duration of the
        given commands.
    channels : names of the channels to keep, such as 'heading_rad'; None: all that a record would have.
    every : of every so many samples one is kept.
    indices : numbers of each run's own motion, without noise: 'first_overshoot' and 'second_overshoot' of a zigzag,
        rad; 'advance', 'transfer', 'tactical_diameter' and 'steady_radius' of a turn, m, its 'steady_speed', m/s, and
        'steady_yaw_rate', rad/s; 'initial_turning' of either, m.
    jobs : number of threads; None: one for each processor.

    Returns
    -------
    time_s (T,), channels name -> (B, T), indices name -> (B,), diverged (B,): a diverging run is not an error, its
    numbers are nan.  `record(i)` gives a run as a record, `to_dataframe()` the samples and `indices_to_dataframe()` the
    indices as pandas tables.

    Raises
    ------
    BadInput : an unknown name or text, values that do not fit the number of runs, a disturbance that the model cannot
        take, no duration or step, or more to keep than fits into the memory: ask for fewer channels or samples.
    """
    from ..bench.environment import cpu_count
    from ..datasets import many
    from ..datasets.disturbances import parse_disturbance
    from ..datasets.generator import check, sampling
    from ..datasets.indices import INDICES
    from ..datasets.sensors import parse_noise

    ship, weather = as_model(model), parse_disturbance(disturbance)
    if runs < 1 or every < 1 or (jobs is not None and jobs < 1):
        raise BadInput(f"runs {runs}, every {every} and jobs {jobs} must be at least 1")
    sets = _coefficients(ship, runs, parameters, coefficients)
    check(ship.with_coefficients(sets[0]), weather, seed)
    steered, length = _manoeuvres(manoeuvre, runs)
    dt, duration = sampling(ship, many.duration_of(ship, duration_s, dt_s, length), dt_s)
    able = _channels(ship, weather)
    plan = many.Plan(
        model=ship,
        manoeuvres=steered,
        coefficients=sets,
        dt=dt,
        duration_s=duration,
        given=_known(initial or {}, ship.states, "state", runs),
        sensors=parse_noise(noise),
        disturbance=weather,
        seed=seed,
        channels=able if channels is None else _chosen(channels, able, "channel"),
        every=every,
        indices=_chosen(indices, INDICES, "index"),
    )
    return many.simulate_runs(plan, jobs or cpu_count())


def _coefficients(
    model: Model, runs: int, parameters: Mapping[str, ArrayLike] | None, coefficients: ArrayLike | None
) -> Array:
    """Coefficients (B, p); BadInput where they are given twice, unknown or not finite."""
    if parameters is not None and coefficients is not None:
        raise BadInput("both parameters and coefficients are given", hint="give one of them")
    width = len(model.coordinates)
    require_memory(3.0 * 8.0 * runs * width, f"the coefficients of {runs} runs")
    given = np.asarray(model.coefficients if coefficients is None else coefficients, dtype=float)
    if given.shape not in ((width,), (runs, width)):
        raise BadInput(f"coefficients have the shape {given.shape}", hint=f"({runs}, {width}) or ({width},) is needed")
    sets = np.array(np.broadcast_to(given, (runs, width)), float)
    if parameters:
        public = np.tile(model.to_parameters(model.coefficients), (runs, 1))
        for name, values in _known(parameters, model.parameter_names, "parameter", runs).items():
            public[:, model.parameter_names.index(name)] = values
        sets = np.array([model.from_parameters(row) for row in public]) if model.kernels.PUBLISHED else public
    if coefficients is not None or parameters:
        bad = ~np.isfinite(sets).all(axis=1)
        if bad.any():
            raise BadInput(f"the coefficients of run {int(bad.argmax())} are not finite")
    return sets


def _known(values: Mapping[str, ArrayLike], names: Sequence[str], kind: str, runs: int) -> dict[str, Array]:
    """Name -> (B,); BadInput for an unknown name, another shape, or a number that is not finite."""
    found: dict[str, Array] = {}
    for name in _chosen(values, names, kind):
        array = np.asarray(values[name], dtype=float)
        if array.shape not in ((), (runs,)):
            raise BadInput(f"{kind} {name!r} has the shape {array.shape}", hint=f"({runs},) or one value is needed")
        if not np.isfinite(array).all():
            raise BadInput(f"{kind} {name!r} is not finite everywhere")
        found[name] = np.array(np.broadcast_to(array, (runs,)))
    return found


def _manoeuvres(given: str | Sequence[str] | Array, runs: int) -> tuple[list[Manoeuvre], int | None]:
    """One manoeuvre for each run or for all, and the number of samples of given commands."""
    from ..datasets.manoeuvres import from_series, parse_manoeuvre

    if isinstance(given, str):
        return [parse_manoeuvre(given)], None
    if isinstance(given, np.ndarray):
        if given.ndim not in (1, 2) or (given.ndim == 2 and len(given) != runs):
            hint = f"(N,) or ({runs}, N) is needed"
            raise BadInput(f"the rudder commands have the shape {given.shape}", hint=hint)
        return [from_series(row) for row in np.atleast_2d(given)], given.shape[-1]
    if len(given) != runs:
        raise BadInput(f"{len(given)} manoeuvres for {runs} runs", hint="give one, or one for each run")
    read = {text: parse_manoeuvre(text) for text in set(given)}
    return [read[text] for text in given], None


def _channels(model: Model, weather: Disturbance) -> list[str]:
    """Channels that a record of the model in this weather has."""
    from ..datasets.many import channel_names

    rolls = weather.waves is not None and model.is_3dof
    return channel_names(model) + ["roll_rad", "roll_rate_rad_s"] * rolls


def _chosen(names: Iterable[str], known: Iterable[str], kind: str) -> list[str]:
    """The names, if all are known."""
    able, wanted = list(known), list(names)
    for name in wanted:
        if name not in able:
            raise BadInput(f"there is no {kind} {name!r}", hint=f"there are {', '.join(able)}")
    return wanted
