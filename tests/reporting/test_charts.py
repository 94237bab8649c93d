"""Plots: well-formed SVG, equal bytes, what cannot be drawn is left out."""

import re
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from helmbench.reporting.diagnosis_suite.page import rate_curves
from helmbench.reporting.plots import embedded, svg
from helmbench.reporting.runs import RecordRuns, charts_of, value_range


def test_rates_are_drawn_with_their_names():
    rows = [("one", 1.0, 0.2, 0.1, 0.5), ("one", 10.0, 0.9, 0.8, 1.0), ("two", 3.0, 0.5, 0.4, 0.6)]
    drawn = rate_curves(pd.DataFrame(rows, columns=["method", "middle", "value", "low", "high"]))
    assert ">one</text>" in drawn and ">two</text>" in drawn and ">100%</text>" in drawn


def test_the_same_drawing_has_the_same_bytes_and_leaves_no_figure_open():
    first = svg(lambda figure: figure.subplots().plot([1, 2], [3, 4], "o"))
    assert first == svg(lambda figure: figure.subplots().plot([1, 2], [3, 4], "o"))
    assert plt.get_fignums() == [] and "<metadata>" not in first


def test_an_embedded_drawing_has_a_title_and_no_names_of_groups():
    text = embedded(svg(lambda figure: figure.subplots().plot([1, 2], [3, 4])), 'errors & "rates"')
    root = ElementTree.fromstring(text)
    assert root.attrib["aria-label"] == 'errors & "rates"' and "<?xml" not in text
    assert not re.findall(r'id="[a-zA-Z0-9]+_\d+"', text)
    for name in re.findall(r"url\(#(.*?)\)", text):
        assert f'id="{name}"' in text


def test_ranges_follow_the_measured_values():
    measured, wild = np.array([0.0, 1.0, np.nan]), np.array([0.5, 1e9, -np.inf])
    low, high = value_range([measured, wild])
    assert -2.5 < low < 0.0 and 3.0 <= high < 3.5
    assert value_range([np.array([np.nan])]) is None
    zero = np.zeros(1)
    assert value_range([zero, wild], 2.0)[1] == pytest.approx(2.0, rel=0.1)
    assert value_range([zero, measured], 2.0)[0] < 0.0


def test_what_is_not_finite_is_not_drawn():
    nothing = np.full(5, np.nan)
    some = {"yaw_rate_rad_s": np.ones(5), "surge_m_s": nothing, "north_m": nothing, "east_m": nothing}
    ((_, drawn),) = charts_of(RecordRuns("one", "", np.arange(5.0), np.zeros(5), some, {"model": some}))
    assert "yaw rate" in drawn and "surge" not in drawn


def test_a_long_series_does_not_make_a_long_file(rng):
    time = np.arange(60_000.0)
    measured, run = ({"surge_m_s": rng.normal(size=time.size)} for _ in range(2))
    ((_, drawn),) = charts_of(RecordRuns("one", "", time, np.zeros(time.size), measured, {"model": run}))
    assert len(drawn) < 400_000
