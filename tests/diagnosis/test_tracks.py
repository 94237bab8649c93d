"""Sensor causes that the track shows by itself, injected by a simulator that shares no code."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets.instruments import corrected, observed
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.diagnosis.prepared import Prepared
from helmbench.models.model import resolve

from ..expectations.injections import passes

CAUSES = ("speed_scale", "sway_offset", "heading_offset", "axis_misalignment", "velocity_delay")
SHIPS = ("mariner", "s175", "kvlcc2-l7")


def compare(records):
    return Prepared(records, []).compared(positions_only=True)


def records(cause, rng, strength="large"):
    case = FaultCase(
        str(rng.choice(SHIPS)), (cause,) if cause else (), strength, gusts=str(rng.choice(["none", "fast"]))
    )
    return inject(case, rng)


@pytest.mark.parametrize("cause", CAUSES)
def test_the_track_shows_it(cause, rng):
    """Mean sizes near their floor are below it in a few draws of a hundred."""

    def shown():
        injected = records(cause, rng)
        found = compare(injected.train).findings
        print(injected.truth[0], found)
        return any(cause in (f.cause, *f.tied_with) for f in found)

    assert passes(shown, 0.93)


@pytest.mark.parametrize("cause", ["", "wind", "current", "loading_change"])
def test_nothing_is_found_where_dynamics_are_wrong(cause, rng):
    """Wind, current and a bad coefficient leave the track alone."""
    assert passes(lambda: not compare(records(cause, rng).train).findings, 0.998)


def test_sizes_put_the_records_right(rng):
    """A scale of 1 % and a sway offset together, from noise-free channels."""
    true = inject(FaultCase("mariner", ()), rng).train
    errors = {"surge_scale": 0.01, "sway_scale": 0.01, "sway_bias": 0.05}
    found = compare([observed(r, errors) for r in true])
    assert {f.cause for f in found.findings} == {"speed_scale", "sway_offset"}
    back = corrected(observed(true[0], errors), found.instruments)
    for name in ("surge_m_s", "sway_m_s"):
        assert back.column(name) == pytest.approx(true[0].column(name), abs=0.02)


def test_a_size_below_the_floor_is_neither_told_nor_corrected(rng):
    """A scale of .1 %, a fifth of the floor, that channels show beyond doubt."""
    true = inject(FaultCase("mariner", ()), rng).train
    found = compare([observed(r, {"surge_scale": 1e-3, "sway_scale": 1e-3}) for r in true])
    assert found.findings == () and found.instruments == {}
    assert found.tested["speed_scale"] > 20.0


def test_records_without_a_track_say_nothing(rng):
    bare = [r.with_channels(north_m=None) for r in inject(FaultCase("mariner", ()), rng).train]
    assert compare(bare) == Prepared(bare, [])


@pytest.mark.nightly
def test_a_response_model_is_told_of_the_log(rng):
    """The model knows no sway and no track: the stage names the log's scale and the extended model carries it."""
    injected = inject(FaultCase("mariner", ("speed_scale",), "large"), rng)
    vessel = resolve("nomoto-1")
    found = diagnose(
        replace(vessel, positive_rudder=resolve("mariner").positive_rudder),
        injected.train,
        options=Options(base_parameters="identify", max_effects=1),
    )
    kinematic = [f for f in found.causes if f.stage == "kinematics"]
    assert [f.cause for f in kinematic] == ["speed_scale"]
    size = injected.truth[0]["parameters"]["s"]
    assert found.extended.instruments["sway_scale"] == pytest.approx(size, rel=0.2)
    entries = {e.cause: e.status for e in found.bank}
    assert entries["speed_scale"] == "named" and entries["heading_offset"] == "not_significant"
    assert np.isfinite(found.wall_s)
