"""Models from published tables: accelerations beside Abkowitz' polynomials written out here, and tables with faults."""

import json

import numpy as np
import pytest

from helmbench.cli import status_of
from helmbench.models.errors import BadInput
from helmbench.models.export.formats import exported
from helmbench.models.model import resolve
from helmbench.models.parameter_table import model_of_table, plain
from helmbench.models.simulate import accelerations, initial_state, inputs_of

TABLE = """name,value (x 10^-5),unit
X_u,-184,
X'_{vv},-899,
Y_v,-1160,
Y_r,-499,
Y_{\\delta},278,
N_v,-264,
N_r,-166,
Nd,-139,
N_{vvr},-5483,
m,798,
x_G,-23,1e-3
I_z,39.2,
X_{\\dot u},-42,
Yvdot,-748,
Y_{\\dot{r}},-9.354,
N_vdot,4.646,
Nrdot,-43.8,
L,160.93,m
U0,15,kn
"""


def written(folder, text, name="table.csv"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_table_gives_the_accelerations_of_the_published_polynomials(tmp_path):
    model = model_of_table(written(tmp_path, TABLE), "abkowitz", "port", None, None)
    length, speed0 = 160.93, 15 * 1852 / 3600
    u, v, r, delta = 7.0, -0.6, 0.008, 0.2
    state = np.array(initial_state(model), dtype=float)
    state[[model.states.index(name) for name in "uvr"]] = u, v, r
    speed = np.hypot(u, v)
    du, dv, dr = (u - speed0) / speed, v / speed, r * length / speed
    x = -0.00184 * du - 0.00899 * dv**2
    y = -0.0116 * dv - 0.00499 * dr + 0.00278 * delta
    n = -0.00264 * dv - 0.00166 * dr - 0.00139 * delta - 0.05483 * dv**2 * dr
    m, xg = 0.00798, -0.023
    mass = [[m + 0.00748, m * xg + 9.354e-5], [m * xg - 4.646e-5, 0.000392 + 0.000438]]
    sway, yaw = np.linalg.solve(mass, [y, n])
    wanted = speed**2 / length * np.array([x / (m + 0.00042), sway, yaw / length])
    found = accelerations(model, state[None], inputs_of(model, np.array([delta])))[0]
    np.testing.assert_allclose(np.ravel(found)[:3], wanted, rtol=1e-9)
    assert model.speed_m_s == pytest.approx(speed0)


def test_the_table_of_mmgdynamics_gives_the_model_it_was_written_from(tmp_path):
    first = resolve("kvlcc2-l7")
    ((name, text),) = exported(first, "mmgdynamics").items()
    again = model_of_table(written(tmp_path, text, name), "mmg", "starboard", first.speed_m_s, first.n0_rps)
    np.testing.assert_allclose(again.coefficients, first.coefficients, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(again.constants, first.constants, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("name", ["Lpp", "rho", "eta"])
def test_a_size_of_zero_in_a_table_of_mmgdynamics_is_one_line(name, tmp_path):
    ((file, text),) = exported(resolve("kvlcc2-l7"), "mmgdynamics").items()
    path = written(tmp_path, json.dumps(json.loads(text) | {name: 0.0}), file)
    with pytest.raises(BadInput, match="Lpp, rho or eta is 0"):
        model_of_table(path, "mmg", "starboard", 1.2, 10.0)


def test_spellings_of_a_name():
    assert {plain(name) for name in ("Xudot", r"X_{\dot u}", r"X'_{\dot{u}}", "X_udot")} == {"Xudot"}
    assert {plain(name) for name in ("Nvvd", r"N_{vv\delta}", "N'_vvd", "N_vvδ")} == {"Nvvd"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("N_{vvr}", "N_{vvrq}", "row 10, column name: unknown parameter 'N_{vvrq}'; did you mean Nvvr?"),
        ("Y_r,", "Y'v,", "row 5, column name: Yv stands twice (also in row 4)"),
        ("-1160", "-11b0", "row 4, column value (x 10^-5): '-11b0' is not a number such as"),
        ("160.93,m", "160.93,kg", "row 19, column unit: L: the unit is 'kg'"),
        ("Nrdot,-43.8,\n", "", "missing: m33 = Iz - Nrdot needs Nrdot"),
        ("U0,15,kn\n", "", "missing: U0"),
        ("name,value (x 10^-5),unit", "name,value,unit\nX_uu,1,1e400", "row 2, column unit: Xuu: "),
        ("-184", "1" * 140000, "row 2: is no CSV: field larger than field limit"),
        ("160.93,m", "0,m", "row 19: L is 0: 0.3 to 500 is usual"),
        ("U0,15,kn", "U0,-15,kn", "row 20: U0 is -7.71667: 0.1 to 30 is usual"),
        ("name,value", "symbol,value", "row 1: needs the columns name and value"),
    ],
)
def test_a_fault_is_one_line_with_its_place(tmp_path, old, new, said):
    path, output = written(tmp_path, TABLE.replace(old, new, 1)), tmp_path / "model.json"
    with pytest.raises(BadInput) as fault:
        model_of_table(path, "abkowitz", "port", None, None)
    assert said in str(fault.value)
    arguments = ["import-model", str(path), "--family", "abkowitz", "--positive-rudder", "port", "-o", str(output)]
    assert status_of(arguments) == 2
    assert not output.exists()


def test_the_command_writes_a_model_that_is_read_again(tmp_path):
    path, output = written(tmp_path, TABLE), tmp_path / "model.json"
    arguments = ["import-model", str(path), "--family", "abkowitz", "--positive-rudder", "port", "-o", str(output)]
    assert status_of(arguments) == 0
    assert resolve(output).parameters["Nvvr"] == pytest.approx(-0.05483)
