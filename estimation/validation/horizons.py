"""Times ahead at which predictions are compared with a record, from the ship's own time, and what they must beat.

A prediction that is no better than that of somebody who looks at the compass and knows no model is of no use.  Two such
predictions stand beside every model: the ship goes on turning as now, and the ship goes on straight.  A model is
trusted as far ahead as it is better than both, in heading and in yaw rate.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit
from ...models.model import Model
from ...models.time_scale import OWN_TIME, time_scale_s
from .result import ErrorScore

LENGTHS = (0.5, 1.5, 3.0, 6.0, 12.0)
"""Times ahead in ship lengths travelled: 10, 31, 62, 124 and 249 s for a ship of 160 m at 15 kn."""
SHARES = (1.0 / 60.0, 1.0 / 20.0, 1.0 / 10.0)
"""Times ahead as shares of the records' median duration where the ship's length or speed is not known."""
TURNS_ON, STRAIGHT = "constant rate of turn", "constant heading"
TIE = 0.02
"""Share by which errors may be larger and still count as equal."""
TRUSTED = ("heading_rad", "yaw_rate_rad_s")
"""Channels in which a model must be better than both simple predictions."""


def horizons_of(models: Iterable[Model], records: Sequence[Record]) -> tuple[tuple[float, ...], str]:
    """Times ahead in s for all models alike, and how they were chosen.

    They are those of the first model that knows its length; its speed may come from the records.

    Where none does, the craft's own time that a model built from records states takes the place of L/U, or else the
    time of a response model's gain and time constant.
    """
    models, longest = list(models), max(float(record.time_s[-1] - record.time_s[0]) for record in records)
    for model in models:
        length, speed = length_of(model), _speed(model, records)
        if np.isfinite(length) and np.isfinite(speed):
            own = length / speed
            source = "the model" if np.isfinite(model.speed_m_s) else "the records"
            basis = f"ship lengths at L/U = {length:.4g} m / {speed:.3g} m/s = {own:.3g} s (speed of {source})"
            return _in_lengths(own, basis, longest)
    for model in sorted(models, key=lambda model: OWN_TIME not in model.particulars):
        own = _response_time_s(model)
        if np.isfinite(own):
            source = ".6 / yaw rate of a hard turn" if OWN_TIME in model.particulars else "sqrt(T / K)"
            basis = f"times {source} = {own:.3g} s, which is about L/U (no ship length or speed is known)"
            return _in_lengths(own, basis, longest)
    duration = float(np.median([record.time_s[-1] - record.time_s[0] for record in records]))
    basis = (
        f"1/60, 1/20 and 1/10 of the records' median duration of {duration:.4g} s (no ship length or speed is known)"
    )
    return tuple(duration * share for share in SHARES), basis


def _in_lengths(own_s: float, basis: str, longest_s: float) -> tuple[tuple[float, ...], str]:
    """Those of LENGTHS that a record is long enough for, at least the first, in s; own_s : L/U."""
    shares = [share for share in LENGTHS if own_s * share <= longest_s] or [LENGTHS[0]]
    basis = f"{', '.join(f'{share:g}' for share in shares)} {basis}"
    return tuple(own_s * share for share in shares), basis


class Simple:
    """A prediction without a model, in the place of one whose states are `states`: see the module.

    Velocities stay as they are, but a ship that goes straight has no sway.
    """

    def __init__(self, states: Sequence[str], turns: bool) -> None:
        self.states, self.turns = list(states), turns

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """States (M + 1, n), see `Predictor`."""
        here = np.array(start, float)
        here[[i for i, s in enumerate(self.states) if s in ("w", *(() if self.turns else ("r", "v")))]] = 0.0
        states = np.tile(here, (len(inputs), 1))
        if {"psi", "r"} <= set(self.states):
            r, psi = self.states.index("r"), self.states.index("psi")
            states[:, psi] += here[r] * dt * np.arange(len(inputs))
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """States (N, n) one sample ahead, see `Predictor`."""
        return np.array([self.simulate(inputs[:2], dt, state)[-1] for state in states])


def trusted_s(scores: Sequence[ErrorScore], simple: Sequence[ErrorScore], model: str) -> float:
    """Time ahead, s, up to which a model's errors over all records are below those of both simple predictions.

    0 where they are not at the shortest time ahead; nan where no time ahead was tried.  A tie at the shortest times,
    where every prediction is good, is no failure of a model that is better beyond them.
    """
    better, tied = (better_at(scores, simple, model, slack) for slack in (0.0, TIE))
    trusted = 0.0 if better else np.nan
    for time, is_better in better.items():
        if is_better:
            trusted = time
        elif trusted > 0.0 or not tied[time]:
            break
    return trusted


def better_at(
    scores: Sequence[ErrorScore], simple: Sequence[ErrorScore], model: str, slack: float = 0.0
) -> dict[float, bool]:
    """Time ahead, s, in rising order -> whether a model's errors over all records are below those of both simple
    predictions, or above them by less than a share `slack`."""
    better = {}
    for time in sorted({s.horizon_s for s in simple if s.horizon_s is not None}):
        own = {s.channel: s.rmse for s in scores if (s.model, s.record, s.horizon_s) == (model, None, time)}
        rivals = [s for s in simple if s.horizon_s == time and s.channel in TRUSTED]
        better[time] = bool(rivals) and all(own.get(s.channel, np.inf) < (1.0 + slack) * s.rmse for s in rivals)
    return better


def mean_ratio(
    scores: Sequence[ErrorScore], new: str, old: str, up_to_s: float = np.inf, channels: Sequence[str] = TRUSTED
) -> float:
    """Geometric mean, over channels and the times ahead up to one, of one model's errors over another's; nan where they
    share none."""
    found = {
        (s.model, s.channel, s.horizon_s): s.rmse
        for s in scores
        if s.record is None and s.horizon_s is not None and s.horizon_s <= up_to_s
    }
    pairs = [
        (rmse, found[old, channel, time])
        for (model, channel, time), rmse in found.items()
        if model == new and channel in channels and (old, channel, time) in found
    ]
    ratios = [np.log(a / b) for a, b in pairs if a > 0.0 and b > 0.0]
    return float(np.exp(np.mean(ratios))) if ratios else np.nan


def length_of(model: Model) -> float:
    """The ship's length, m; nan where the model does not know it."""
    constants = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    return float(model.particulars.get("L", constants.get("L", np.nan)))


def _response_time_s(model: Model) -> float:
    """Time scale of a response model with coefficients, s; nan where there is none."""
    try:
        return time_scale_s(model) if model.known else np.nan
    except CannotFit:
        return np.nan


def _speed(model: Model, records: Sequence[Record]) -> float:
    """Speed of the straight course, m/s, else the median measured surge; nan where neither is known."""
    if np.isfinite(model.speed_m_s):
        return model.speed_m_s
    surge = [record.column("surge_m_s") for record in records if record.has("surge_m_s")]
    known = np.concatenate([np.zeros(0), *surge])
    known = np.abs(known[np.isfinite(known)])
    return float(np.median(known)) if known.size and np.median(known) > 0.0 else np.nan
