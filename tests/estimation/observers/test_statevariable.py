"""The state-variable filter."""

import numpy as np
import pytest

from helmbench.estimation.observers import linear
from helmbench.estimation.observers.linear import derivatives, respond, sampled_filter, transients
from helmbench.estimation.regression.filtered import sharpened


def test_filter_of_a_ramp_is_exact(rng):
    """F(s) leaves a ramp delayed by n/omega after its transient, and its derivatives exact."""
    slope, offset = rng.normal(size=2)
    time = 0.1 * np.arange(4000)
    found = derivatives(offset + slope * time, 0.1, 0.5, 4)
    assert found[-1] == pytest.approx([offset + slope * (time[-1] - 4 / 0.5), slope, 0, 0, 0], abs=1e-11)
    assert found[0, 0] == offset and not found[0, 1:4].any()


def test_filter_keeps_its_digits_at_slow_corners(rng):
    """At omega dt = 1e-3 the transfer-function form has lost all digits of the third derivative."""
    dt, omega = 0.02, 0.05
    w = rng.uniform(0.01, 0.05)
    time = dt * np.arange(100_000)
    found = derivatives(sharpened(np.sin(w * time)), dt, omega, 4)
    gain = (omega / (1j * w + omega)) ** 4
    for k in range(5):
        exact = np.imag((1j * w) ** k * gain * np.exp(1j * w * time))
        assert np.abs(found[60_000:, k] - exact[60_000:]).max() < 1e-7 * omega**k


def test_transients_span_what_the_filters_start_adds(rng):
    a, dt, omega = rng.normal(size=4), 0.1, 0.7
    free = respond(sampled_filter(omega * dt, 4), np.zeros((200, 1)), a)
    basis = transients(200, dt, omega, 4)
    left = free - basis @ np.linalg.lstsq(basis, free, rcond=None)[0]
    assert np.abs(left).max() < 1e-11 * np.abs(free).max()


@pytest.mark.parametrize("every", [1, 3, 50])
@pytest.mark.parametrize("highest", [1, 4])
def test_blocks_make_no_difference(highest, every, rng, monkeypatch):
    signal = np.cumsum(rng.normal(size=101))
    whole = derivatives(signal, 0.1, 0.5, 4, highest)
    for block in (1, 20, 101):
        monkeypatch.setattr(linear, "BLOCK", block)
        assert derivatives(signal, 0.1, 0.5, 4, highest, every) == pytest.approx(whole[::every], rel=1e-12)
