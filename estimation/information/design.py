"""Which further manoeuvre tells most about the numbers that records leave open.

A candidate is simulated with the model, and its information added to that of the records.  D-optimality: the gain is
half the growth of the log determinant of the information, in nats.
Source: Atkinson, Donev & Tobias 2007, Optimum Experimental Designs, with SAS, ch 11; with a prior Chaloner & Verdinelli
1995, Stat. Sci. 10(3), 273-304.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.generator import record_run
from ...datasets.manoeuvres import parse_manoeuvre
from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit
from ...models.model import Model
from .bounds import information

LONGEST = 2500
"""Samples of a simulated candidate; longer ones are thinned and their noise is reduced accordingly."""
DEGREE = np.deg2rad(1.0)


def information_gain(now: np.ndarray, more: np.ndarray) -> float:
    """Half the growth of the log determinant, nats, when information `more` (q, q) is added to `now` (q, q).

    now : regular, so with a prior where the records leave a direction open.
    """
    return 0.5 * float(np.linalg.slogdet(now + more)[1] - np.linalg.slogdet(now)[1])


def candidate_information(
    model: Model, records: Sequence[Record], noise: Mapping[str, float], manoeuvres: Sequence[str] | None
) -> Iterator[tuple[str, np.ndarray]]:
    """Manoeuvres and the factor (<= p, p) of the information of one record of each on the coefficients.

    A candidate has the duration and step of the longest record.

    Parameters
    ----------
    noise : standard deviation by channel name.
    manoeuvres : texts of manoeuvres; None: `usual_manoeuvres`.  One that the model cannot sail is left out.

    Raises
    ------
    BadInput : a text is no manoeuvre.
    """
    longest = max(records, key=lambda record: record.time_s[-1] - record.time_s[0])
    duration = float(longest.time_s[-1] - longest.time_s[0])
    stride = max(1, -(-round(duration / longest.dt) // LONGEST))
    thinned = {channel: sd / np.sqrt(stride) for channel, sd in noise.items()}
    vessel = replace(model, suite={})
    for text in usual_manoeuvres(model, records, duration) if manoeuvres is None else manoeuvres:
        manoeuvre = parse_manoeuvre(text)
        try:
            record = record_run(vessel, manoeuvre, duration_s=duration, dt_s=stride * longest.dt)
            yield manoeuvre.text, information(model, record, thinned)
        except (BadInput, CannotFit):
            continue  # the model diverges, or lacks what the manoeuvre needs


def usual_manoeuvres(model: Model, records: Sequence[Record], duration: float) -> list[str]:
    """Some manoeuvres with rudder angles and times similar to those of the records."""
    steered = max(float(np.nanmax(np.abs(record.rudder()))) for record in records) / DEGREE
    most = int(min(max(20.0, np.ceil(steered)), model.rudder.max_rad / DEGREE))
    half = max(most // 2, 1)
    brief, long = (f"{duration / parts:.3g}s" for parts in (40, 12))
    return [
        *(f"zigzag:{angle}/{angle}" for angle in (half, most)),
        *(f"turn:{angle}" for angle in (half, most)),
        f"turn:{most}:port",
        f"sine:{most}deg/{duration / 4:.3g}s",
        f"sine:{half}deg/{duration / 4:.3g}s+{half}deg/{duration / 16:.3g}s",
        *(f"prbs:{most}deg/{clock}" for clock in (brief, long)),
        *(f"steps:{most}deg/{clock}" for clock in (brief, long)),
    ]
