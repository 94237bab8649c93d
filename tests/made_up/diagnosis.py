"""A diagnosis made by hand: generated records, the extension that they were made with, no engine."""

from dataclasses import replace

import numpy as np

from helmbench.checks.result import Size
from helmbench.datasets.generator import record_run
from helmbench.datasets.instruments import corrected
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import parse_noise
from helmbench.diagnosis.result import Diagnosis, Entry, Finding, Gain, Trace
from helmbench.models.extend import extended
from helmbench.models.families.extensions import extensions
from helmbench.models.instruments import INSTRUMENTS
from helmbench.models.model import CHANNELS, resolve
from helmbench.models.simulate import initial_state, simulate

DEGREE = np.pi / 180.0


def run(model, record):
    """Channels of a free run with the record's rudder as the model's hull feels it."""
    felt = corrected(record, model.instruments)
    inputs = np.column_stack([felt.rudder()] + [np.full(record.n, model.n0_rps)] * (len(model.inputs) - 1))
    states = simulate(model, inputs, record.dt, initial_state(model))
    return {CHANNELS[s]: states[:, i] for i, s in enumerate(model.states) if s in CHANNELS}


def trace(base, extension, record, role):
    measured = {name: values for name, values in record.channels.items() if name in CHANNELS.values()}
    rudder = measured.pop("rudder_rad")
    measured.pop("propeller_rps", None)
    return Trace(record.name, role, record.time_s, rudder, measured, run(base, record), run(extension, record))


def gains(traces):
    """Plain errors before and after, pooled; intervals are made up around the ratio."""
    found = {}
    held_out = [t for t in traces if t.role == "held_out"]
    for name in held_out[0].measured if held_out else ():
        pairs = [(t.measured[name] - getattr(t, run)[name]) for run in ("before", "after") for t in held_out]
        before, after = (np.concatenate(pairs[i::1][: len(held_out)]) for i in (0, len(held_out)))
        a, b = (float(np.sqrt(np.nanmean(e**2))) for e in (before, after))
        spread = np.nanvar(np.concatenate([t.measured[name] for t in held_out]))
        found[name] = Gain(a, b, 0.8 * b / a, 1.2 * b / a, 1 - a * a / spread, 1 - b * b / spread, 1 - b / a)
    return found


def made_up(
    vessel="mariner", extension="yaw_damping_quadratic", values=None, instruments=None, verdict="named", held=2
):
    """A diagnosis of records made with one extension."""
    base = resolve(vessel)
    truth = extended(base, extension, values) if extension else base
    truth = replace(truth, instruments=instruments or {})
    sensors = parse_noise("medium")
    told = ["zigzag:20/20", "turn:35", "zigzag:10/10", "zigzag:20/10"][: 2 + held]
    records = [
        replace(record_run(truth, parse_manoeuvre(m), sensors, seed=i, duration_s=400, dt_s=0.5), name=f"run_{i}")
        for i, m in enumerate(told)
    ]
    roles = ["train"] * 2 + ["held_out"] * held
    traces = tuple(trace(base, truth, record, role) for record, role in zip(records, roles, strict=True))
    cause = extension or next(iter(instruments or {}), "rudder_offset")
    size = next(iter((values or instruments or {"b": 0.01}).items()))
    units = INSTRUMENTS | (extensions()[extension].units if extension else {})
    finding = Finding(
        cause,
        ("constant_force",) if verdict == "tied" else (),
        "dynamics",
        212.0,
        3e-9,
        (Size(size[0], size[1], 0.9 * size[1], 1.1 * size[1], units.get(size[0], "1")),),
        evidence="The innovations of the yaw rate follow the term in both turning directions.",
        separate_by="straight runs at two speeds",
    )
    bank = (
        Entry(cause, verdict if verdict in ("named", "tied") else "not_significant", 212.0, 3e-9, 0.99, "passes"),
        Entry("rudder_effectiveness", "explained_by", 88.0, 0.4, 0.97, f"nothing left after {cause}"),
        Entry("wind", "not_significant", 3.1, 0.93, 0.88, "below the level"),
        Entry("speed_loss", "not_testable", None, None, None, "surge is a state of the model already"),
    )
    named = verdict in ("named", "tied")
    return Diagnosis(
        model=base,
        extended=replace(truth, id="extended") if named else base,
        base_parameters="file",
        records=tuple((f"{r.name}.csv", role) for r, role in zip(records, roles, strict=True)),
        alpha=0.01,
        seed=3,
        verdict=verdict,
        reason="The sensor-only gate fails at p = 1e-12 and passes with the extension.",
        causes=(finding,) if named else (),
        bank=bank,
        gain=gains(traces),
        hypothesis=None,
        noise={
            "sensor_sd": {"heading_rad": 0.1 * DEGREE, "yaw_rate_rad_s": 0.05 * DEGREE},
            "force_sd": [10.0, 20.0, 300.0],
            "correlation_time_s": 15.0,
            "rudder_sd": 0.05 * DEGREE,
        },
        traces=traces,
        where=(
            {
                "channel": "yaw_rate_rad_s",
                "condition": "turns to starboard",
                "share_of_error": 0.71,
                "share_of_time": 0.4,
            },
        ),
        next_manoeuvre=None if named else "a 20/20 zigzag",
        wall_s=7.1,
        cpu_s=11.9,
    )
