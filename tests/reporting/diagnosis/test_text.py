"""Sentences and sizes of a diagnosis."""

from dataclasses import replace

import pytest

from helmbench.diagnosis.result import Size
from helmbench.reporting.diagnosis import text as words

from ...made_up_diagnosis import made_up


@pytest.mark.parametrize(
    ("item", "text"),
    [
        (Size("delta0", 0.01, 0.009, 0.011, "rad"), "delta0 0.573 deg [0.516, 0.63]"),
        (Size("e", -0.2, -0.25, -0.15, "1"), "e -20 % [-25, -15]"),
        (Size("Nrr", -0.003, -0.0030021, -0.0029979, "1"), "Nrr -0.003 [-0.0030021, -0.0029979]"),
        (Size("speed", 0.2, 0.1, 0.3, "m/s", "run_1"), "speed 0.2 m/s [0.1, 0.3] in run_1"),
        (Size("t0", 100.0, float("nan"), float("nan"), "s"), "t0 100 s [–, –]"),
    ],
)
def test_sizes_have_their_usual_units(item, text):
    assert words.size(item) == text


def test_the_verdict_names_cause_size_and_gain():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    text, gain = words.verdict(found), found.gain["yaw_rate_rad_s"]
    _, unit, factor = words.channel("yaw_rate_rad_s")
    assert text.startswith("The simulation lacks rudder offset (")
    assert words.size(found.causes[0].sizes[0]) in text
    before, after = (words.number(factor * value) for value in (gain.rmse_before, gain.rmse_after))
    assert f"of the yaw rate from {before} to {after} {unit}" in text


def test_the_terminal_shows_the_gain_as_a_table():
    found = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})
    lines = words.terminal(found).splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("  channel"))
    rows = lines[head + 1 : head + 1 + len(found.gain)]
    assert [row.split("  ")[1] for row in rows] == [words.channel(name)[0] for name in found.gain]


def test_channels_that_are_predicted_worse_are_told():
    found = made_up()
    gain = found.gain["heading_rad"]
    worse = replace(found, gain=found.gain | {"heading_rad": replace(gain, rmse_after=1.2 * gain.rmse_before)})
    said = "Held-out records are predicted worse than by the base model in heading: use the extended model with care."
    assert words.verdict(worse).endswith(said)
    assert "with care" not in words.verdict(found)
