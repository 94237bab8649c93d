"""Equations of extended models in LaTeX and MathML."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
import sympy as sp

from helmbench.models.errors import BadInput
from helmbench.models.extend import extended
from helmbench.models.families.extensions import extensions
from helmbench.models.model import resolve
from helmbench.models.primitives import absv, atan2v
from helmbench.reporting.equation_lines import Latex, equation, parts, rounded
from helmbench.reporting.equations import equations

HTML_NAMES = re.compile("&[A-Z][A-Za-z]+;")
"""Characters by names that HTML knows and XML does not."""


def lines(vessel, *extensions, **instruments):
    base = resolve(vessel)
    model = base
    for name in extensions:
        model = extended(model, name)
    return equations(replace(model, instruments=instruments), base)


def test_an_added_term_is_marked_in_its_equation_alone():
    found = lines("mariner", "yaw_damping_quadratic")
    assert [line.new for line in found.dynamics] == [False, False, True, False, False, False]
    (marked,) = re.findall(r"<span class='term new'>(.*?)</span>$", found.dynamics[2].html.split("\n")[-1])
    assert "&#x02032;" in marked and "underbrace" in found.dynamics[2].latex
    assert "Xvvu" not in found.dynamics[0].html
    (value,) = found.added
    assert value.new and "(added_Nr_absr)" in value.html and r"(added\_Nr\_absr)" in value.latex


def test_rudder_and_sensors_are_shown_as_relations():
    found = lines("mariner", "rudder_offset", rudder_delay=1.0, yaw_rate_bias=0.01)
    assert found.relations[0].latex == r"\delta_{\mathrm{hull}} = \delta\left(t - \tau_{\delta}\right) + \delta_{0}"
    assert len(found.relations) == 2 and not any(line.new for line in found.dynamics)
    assert "hull" in found.dynamics[1].latex


def test_a_sensor_has_its_scale_bias_and_delay():
    found = lines("mariner", surge_scale=0.1, surge_bias=0.2, surge_delay=0.5)
    expected = r"\left(s + 1\right) \text{surge}_{\mathrm{true}}\left(t - \tau_{\mathrm{surge}}\right) + b"
    assert found.relations[0].latex == r"\text{surge}_{\mathrm{recorded}} = " + expected


def test_turned_axes_and_exchanged_columns_are_stated():
    found = lines("mariner", axis_misalignment=0.05, earth_frame_velocity=1.0, wave_rms=0.1)
    assert [r"\cos" in line.latex for line in found.relations] == [True, True, True, True, False]


def test_a_new_state_is_a_new_equation():
    found = lines("response-1", "second_order_lead")
    assert found.dynamics[-1].new and found.dynamics[-1].latex.startswith(r"\dot{z} =")


@pytest.mark.parametrize("extension", extensions())
def test_every_extension_is_marked_and_well_formed(extension):
    base = next(
        base for base in map(_with_rigid_body, ("mariner", "response-1", "kvlcc2-l7")) if _fits(base, extension)
    )
    found = equations(extended(base, extension), base)
    assert any(line.new for line in (*found.relations, *found.dynamics, *found.helpers))
    for line in (*found.relations, *found.dynamics, *found.helpers):
        ElementTree.fromstring(f"<p>{HTML_NAMES.sub('', line.html)}</p>")
        assert line.latex.count("{") == line.latex.count("}") and "_abs" not in line.latex


def _with_rigid_body(vessel):
    """A vessel with the constants that a change of loading needs."""
    return replace(resolve(vessel), windage={"rigid_mass": 1e6, "rigid_moment": 1e5, "rigid_inertia": 1e9})


def _fits(base, extension):
    try:
        extended(base, extension)
    except BadInput:
        return False
    return True


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Yvvr", ("Y", "vvr", "")),
        ("Nu", ("N", "u", "")),
        ("m11", ("m", "11", "")),
        ("added_Nr_absr", ("Nprime", "r|r|", "")),
        ("up", ("uprime", "", "")),
        ("iU", ("U", "", "-1")),
        ("delta", ("delta", "", "")),
        ("curr_ur", ("u", "r", "")),
    ],
)
def test_names_are_split_into_letter_index_and_exponent(name, expected):
    assert parts(name) == expected


def test_symbols_and_functions_of_models():
    u, r, delta = sp.symbols("up r delta_rate", real=True)
    assert Latex().doprint(absv(r) * u) == r"{u}' \left|{r}\right|"
    assert Latex().doprint(delta) == r"\dot{\delta}"
    assert Latex().doprint(atan2v(r, u)).startswith(r"\operatorname{atan2}")
    assert Latex().doprint(sp.sin(r)) == r"\sin{\left(r \right)}"


def test_marked_symbols_are_set_off():
    z = sp.Symbol("z")
    assert Latex({"z"}).doprint(z) == r"\boxed{z}" and Latex().doprint(z) == "z"
    line = equation([(sp.Symbol("y"), None)], sp.sin(z) + z, {"z": False})
    assert line.html.count('<mrow class="new"><mi>z</mi></mrow>') == 2 and "box" not in line.html


def test_numbers_have_six_digits():
    assert Latex().doprint(rounded(0.123456789 * sp.Symbol("x"))) == "0.123457 x"
