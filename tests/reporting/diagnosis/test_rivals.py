"""The two models that anyone would try first, on records of a known first-order craft with an offset and a delay."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.diagnosis.craft.windows import pieces_of, scales_of, windows_of
from helmbench.models.model import resolve
from helmbench.reporting.diagnosis.rivals import (
    HISTORY,
    Arx,
    arx,
    arx_errors,
    compared,
    nomoto,
    nomoto_errors,
    stretches_of,
)

GAIN, TIME, OFFSET, LATE = 0.15, 6.0, 0.03, 2.0


def sailed(rng, name, dt=0.5, n=1200):
    """T r' + r = K (d(t - LATE) + OFFSET), solved exactly for a rudder that is linear between samples."""
    time = dt * np.arange(n)
    rudder = 0.25 * sum(
        np.sin(w * time + p) for w, p in zip(rng.uniform(0.03, 0.2, 4), rng.uniform(0, 6, 4), strict=True)
    )
    late = np.interp(time - LATE, time, rudder) + OFFSET
    decay = np.exp(-dt / TIME)
    rate = np.zeros(n)
    for k in range(1, n):
        rate[k] = decay * rate[k - 1] + (1.0 - decay) * GAIN * 0.5 * (late[k] + late[k - 1])
    seen = rate + 1e-5 * rng.standard_normal(n)
    heading = np.concatenate([[0.0], np.cumsum(0.5 * dt * (rate[1:] + rate[:-1]))])
    return Record(time, {"rudder_rad": rudder, "yaw_rate_rad_s": seen, "heading_rad": heading}, name)


@pytest.fixture
def sides(rng):
    return [sailed(rng, "one"), sailed(rng, "two")], [sailed(rng, "three")]


def test_a_first_order_craft_is_recovered_with_offset_and_delay(sides):
    scales = scales_of(sides[0])
    seen, new = (stretches_of(side, scales) for side in sides)
    step = windows_of(pieces_of(sides[0], scales), resolve("nomoto-1"), scales).dt
    found = nomoto(seen)
    assert found.steps * step == pytest.approx(TIME, rel=0.2) and found.delay * step == pytest.approx(LATE, abs=0.6)
    assert found.gain == pytest.approx(GAIN, rel=0.05) and found.turning == pytest.approx(GAIN * OFFSET, rel=0.1)
    assert np.std(nomoto_errors(found, new)) < 0.03 * np.std(new.rate)
    assert np.std(arx_errors(arx(seen), new)) < 0.03 * np.std(new.rate)


def test_a_difference_equation_runs_from_the_history_and_leaves_no_bound(sides):
    scales = scales_of(sides[0])
    windows = stretches_of(sides[1], scales)
    still = arx_errors(Arx(np.array([1.0]), np.zeros(1), 0.0, 0), windows)
    assert still == pytest.approx(windows.smooth[:, [HISTORY]] - windows.ahead, abs=1e-12)
    growing = arx_errors(Arx(np.array([2.0]), np.zeros(1), 0.0, 0), windows)
    assert np.abs(growing).max() <= 10.0 * np.abs(windows.smooth).max() + np.nanmax(np.abs(windows.ahead))


def test_a_true_model_stands_beside_them_and_a_reversed_one_below(sides):
    blank = resolve("nomoto-1+rudder_offset")
    values = {"a": -1.0 / TIME, "b": GAIN / TIME, "rudder_offset": OFFSET}
    true = replace(
        blank, coefficients=np.array([values[n] for n in blank.coordinates]), instruments={"rudder_delay": LATE}
    )
    reversed_ = replace(true, coefficients=true.coefficients * np.where(np.array(blank.coordinates) == "b", -1.0, 1.0))
    right, wrong = (compared(model, *sides) for model in (true, reversed_))
    assert right.craft > 0.999 and min(right.nomoto, right.arx) > 0.99 and wrong.craft < 0.0
    assert (wrong.nomoto, wrong.arx) == (right.nomoto, right.arx)
