"""Numbers that no ship has are refused before a model is made of them, those that hardly any has are warned of."""

import csv
import json
import math
import re
import warnings

import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.models.errors import BadInput
from helmbench.models.model import list_vessels, resolve
from helmbench.models.parameter_table import model_of_table

from .mmgdynamics_tables import SIZES, TABLES
from .test_parameter_table import TABLE, written

FULL = TABLES["kvlcc2_full"]
LEFT_OUT = r"left out, not needed: "
WARNED = {
    "seiunmaru": (
        r"k_1 or k_2 is not there: K_T = J_int \+ J_slo J", r"C_1 and C_2 are not there", LEFT_OUT + "k_0, A_R/Ld_em",
    ),
    "GMS1": (
        r"k_1 or k_2 is not there", r"C_1 and C_2 are not there", r"gamma_R is 0.333: it holds for both sides",
        LEFT_OUT + "k_0, gamma_R_plus, gamma_R_minus, A_R/Ld_em, k_s",
        r"J_z_dash is 1.121e-06: 0.000937 to 0.0225 is usual, 0.005 to 0.12 of m'",
        r"D_p is 1.7: 0.326 to 1.63 is usual, 0.2 to 1 of d",
        r"rudder span \(of D_p and eta\) is 1.77083: 0.489 to 1.63",
        r"epsilon is 2.467: 0.5 to 2 is usual",
    ),
    "kvlcc2": (r"k_2 is -0.1359: Yasukawa & Yoshimura \(2015\) have -0.1385", LEFT_OUT + "J_int, J_slo, A_R/Ld_em"),
    "kvlcc2_full": (r"k_2 is -0.1359: Yasukawa", LEFT_OUT + "J_int, J_slo, A_R/Ld_em"),
}  # fmt: skip
"""Table of mmgdynamics -> lines that are told when it is read, and no others."""


def read(folder, table, side="starboard", family="mmg"):
    """The model of a table, and the lines that warned."""
    path = written(folder, json.dumps(table), "ship.json")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model = model_of_table(path, family, side, 7.0, None)
    return model, [str(one.message).removeprefix("ship.json: ") for one in told]


@pytest.mark.parametrize("name", TABLES)
def test_the_tables_that_mmgdynamics_ships_are_read(name, tmp_path):
    model, told = read(tmp_path, TABLES[name])
    assert len(told) == len(WARNED[name])
    for line in WARNED[name]:
        assert any(re.match(line, one) for one in told), line
    table, own = TABLES[name], dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    assert own["nabla"] == pytest.approx(table["m"] / 1000.0) and own["x_P"] == -0.5
    assert own["I_zz"] == pytest.approx(table["I_zG"] + table["m"] * table["x_G"] ** 2)
    assert model.parameters["N_v"] == table["N_v_dash"] and own["A_R"] == table["A_R"]
    assert model.particulars["B"] == table["B"]


def test_what_mmgdynamics_takes_for_keys_that_are_not_there(tmp_path):
    """Thrust, flow straightening and wake beside its own formulas, written out here."""
    table = {name: value for name, value in TABLES["GMS1"].items() if name != "A_R"}
    model, _ = read(tmp_path, table)
    c = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    assert (c["k_0"], c["k_1"], c["k_2"]) == (0.4, -0.4, 0.0) and c["gamma_R_plus"] == c["gamma_R_minus"] == 0.333
    assert c["A_R"] == pytest.approx(110.0 * 1.631 / 46.8)
    drift = np.array([0.0, math.sqrt(math.log(2.0)) / 2.0, 3.0])
    theirs = 1.0 - 0.4 * np.exp(-4.0 * drift**2)
    ours = 0.6 * (1.0 + (1.0 - np.exp(-c["C_1"] * drift)) * (c["C_2_plus"] - 1.0))
    np.testing.assert_allclose(ours, theirs, rtol=5e-3)


@pytest.mark.parametrize("vessel", list_vessels())
def test_the_numbers_of_every_vessel_are_usual(vessel, tmp_path):
    """A table of them is read without a warning, which would be an error here."""
    model = resolve(vessel)
    path = tmp_path / "table.csv"
    with path.open("w") as file:
        rows = csv.writer(file)
        rows.writerow(("name", "value", "unit"))
        rows.writerows(zip(model.parameters, model.parameters.values(), model.parameter_units, strict=True))
        rows.writerows((name, value, "") for name, value in zip(model.constant_names, model.constants, strict=True))
    speed = model.speed_m_s if math.isfinite(model.speed_m_s) else None
    again = model_of_table(path, model.family, model.positive_rudder, speed, model.n0_rps)
    np.testing.assert_allclose(again.coefficients, model.coefficients, rtol=1e-9)
    other = {"port": "starboard", "starboard": "port"}[model.positive_rudder]
    if vessel in ("cargo", "patrol", "response-2", "remus-kt"):  # of second order: the yaw rate does not jump
        return
    with pytest.raises(
        BadInput, match=f"turns the ship to {model.positive_rudder}, not to {other}; give --positive-rudder"
    ):
        model_of_table(path, model.family, other, speed, model.n0_rps)


IMPOSSIBLE = [
    *(({"m": FULL["m"] / 1000.0}, "m is 312600: "), ({"m": FULL["m"] * 9.81}, "m is "), ({"m": -FULL["m"]}, "m is ")),
    *(({"C_b": 81.0}, "m is "), ({"rho": 1.0}, "m is 3.126e.08: "), ({"B": 5800.0}, "m is ")),
    *(({"N_v_dash": 0.137}, "N_v_dash is 0.137: "), ({"N_r_dash": 0.049}, "N_r_dash"), ({"Y_v_dash": 0.315}, "Y_v_")),
    *(({"N_v_dash": 0.0}, "N_v_dash"), ({"N_r_dash": -49.0}, "N_r_dash"), ({"Y_v_dash": -315.0}, "Y_v_dash")),
    *(({"R_0_dash": -0.022}, "R_0_dash"), ({"R_0_dash": 22.0}, "R_0_dash"), ({"J_z_dash": -0.011}, "J_z_dash")),
    *(({"m_x_dash": -0.022}, "m_x_dash"), ({"m_y_dash": 22.3}, "m_y_dash"), ({"J_z_dash": 11.0}, "J_z_dash")),
    *(({"I_zG": 2e9}, "radius of gyration"), ({"I_zG": 2e15}, "radius of gyration"), ({"I_zG": -2e12}, "radius")),
    *(({"x_P": 160.0}, "x_P/Lpp is 0.5: "), ({"x_P": -0.5}, "x_P/Lpp"), ({"x_P": -160e3}, "x_P/Lpp")),
    *(({"A_R": 112.5e4}, "A_R is "), ({"A_R": 0.0}, "A_R"), ({"A_R": -112.5}, "A_R"), ({"D_p": 986.0}, "D_p")),
    *(({"D_p": 0.0}, "D_p"), ({"D_p": -9.86}, "D_p"), ({"eta": -0.6}, "rudder span"), ({"eta": 1e-3}, "rudder span")),
    *(({"x_H_dash": -148.0}, "place of the rudder's moment"), ({"a_H": -31.0}, "1 . a_H"), ({"t_R": 38.7}, "1 - t")),
    *(({"w_P0": 35.0}, "w_P0"), ({"t_P": 22.0}, "t_P"), ({"f_alpha": 157.0}, "f_alpha"), ({"epsilon": 0.0}, "epsilon")),
    *(({"l_R": 0.71}, "l_R"), ({"kappa": -5.0}, "kappa"), ({"gamma_R_plus": 36.0}, "gamma_R_"), ({"k_0": 0.0}, "k_")),
    *(({"x_G": 160.0}, "x_G"), ({"d": 2080.0}, "m is "), ({"Lpp": 320e3}, "m is "), ({"C_1": -2.0}, "C_1")),
    *(({"C_2_plus": 160.0}, "C_2_plus"), ({"X_vr_dash": 1e-320}, "X_vr_dash"), ({"Y_rrr_dash": 1e300}, "Y_rrr_dash")),
    *(({name: 1e200}, ".* is (1|3.125)e.1?[29]|.* is inf") for name in SIZES.split()[1:-1]),
    *(({"Lpp": 1e-320}, "Lpp is "), ({"rho": 1e-320}, "the numbers|rho|m is|displaced volume"), ({"d": 0.0}, "d is")),
]  # fmt: skip


@pytest.mark.parametrize(("change", "said"), IMPOSSIBLE)
def test_what_no_ship_has_is_refused_in_one_line(change, said, tmp_path):
    with pytest.raises(BadInput, match=rf"ship.json: ({said})") as fault:
        read(tmp_path, FULL | change)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"J_z_dash": 1.121e-6}, "J_z_dash is 1.121e-06: 0.00147 to 0.0352 is usual"),
        ({"I_zG": 6e11}, "radius of gyration .of I_zG. is 43.8"),
        ({"x_P": -0.69 * 320.0}, "x_P/Lpp is -0.69: -0.6 to -0.4 is usual"),
        ({"m": 3.0e8}, "m is 3e.08: 3.03e.08 to 3.22e.08 is usual, 0.97 to 1.03 of C_b L B d rho"),
        ({"D_p": 25.0, "eta": 1.4}, "D_p is 25: 4.16 to 20.8 is usual"),
        ({"A_R": 20.0}, "A_R is 20: 53.2 to 466 is usual, 0.008 to 0.07 of L d"),
        ({"m_y_dash": 0.004}, "m_y_dash"),
        ({"N_r_dash": -1.0}, "N_r_dash is -1: -0.3 to -0.003 is usual"),
        ({"x_G": 40.0}, "x_G is 40: -19.2 to 19.2 is usual"),
    ],
)
def test_what_hardly_any_ship_has_is_warned_of(change, said, tmp_path):
    _, told = read(tmp_path, FULL | change)
    assert any(re.match(said, one) for one in told), told


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({k: v for k, v in FULL.items() if k not in ("eta", "t_R", "N_v_dash")}, "missing: N_v_dash, eta, t_R"),
        ({k: v for k, v in FULL.items() if k not in ("C_1", "J_int")}, "missing: C_1; a table of mmgdynamics has it"),
        (FULL | {"m": {"value": 312600.0, "unit": "m3"}}, "m: the unit is 'm3' where 'kg' .or t. is needed"),
        (FULL | {"m": "312600 t"}, "column m: '312600 t' is not a number"),
        (FULL | {"m": True}, "column m: 'True' is not a finite number"),
        (FULL | {"m": [1.0]}, "column m: '.1.0.' is not a finite number"),
        (FULL | {"m": None}, "column m: 'None' is not a finite number"),
    ],
)
def test_a_table_of_mmgdynamics_with_a_fault_is_one_line(table, said, tmp_path):
    with pytest.raises(BadInput, match=said):
        read(tmp_path, table)


def test_a_mass_in_tonnes_that_says_so_is_converted(tmp_path):
    model, _ = read(tmp_path, FULL | {"m": {"value": 312600.0, "unit": "t"}})
    assert model.constants[model.constant_names.index("nabla")] == pytest.approx(312600.0)


NOMOTO = {"T": 8.0, "K": 0.12}


@pytest.mark.parametrize("value", [0.0, 1e-320, 1e-9, 1e9, 1e300])
@pytest.mark.parametrize("name", NOMOTO)
def test_a_first_order_model_has_a_time_and_a_gain(name, value, tmp_path):
    with pytest.raises(BadInput, match=f"ship.json: {name} is "):
        read(tmp_path, NOMOTO | {name: value}, family="nomoto-1")


def test_an_unstable_ship_is_one(tmp_path):
    """T and K below 0: the ship turns to the side of the rudder at first."""
    model, told = read(tmp_path, {"T": -80.0, "K": -0.12}, family="nomoto-1")
    assert model.parameters["T"] == pytest.approx(-80.0) and not told
    with pytest.raises(BadInput, match="turns the ship to port, not to starboard"):
        read(tmp_path, {"T": -80.0, "K": 0.12}, family="nomoto-1")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("value (x 10^-5)", "value", "Yv is -1160: -0.1 to -0.001 is usual|m is 798: |m11 is "),
        ("N_v,-264", "N_v,264", "row 7: Nv is 0.00264: -0.03 to -0.0001 is usual"),
        ("N_r,-166", "N_r,166", "row 8: Nr is 0.00166"),
        ("Y_v,-1160", "Y_v,1160", "row 4: Yv is 0.0116"),
        ("Nd,-139", "Nd,139", "turns the ship to starboard, not to port"),
        ("I_z,39.2", "I_z,3.92e5", "Iz is 3.92|m33 is "),
        ("L,160.93,m", "L,160.93,km", "row 19: L is 160930"),
        ("U0,15,kn", "U0,1e-20,kn", "U0 is 5.14444e-21"),
    ],
)
def test_a_slip_in_a_table_of_derivatives_is_one_line(old, new, said, tmp_path):
    path = written(tmp_path, TABLE.replace(old, new, 1))
    with pytest.raises(BadInput, match=said):
        model_of_table(path, "abkowitz", "port", None, None)


def test_the_command_tells_and_writes_or_refuses(tmp_path, capsys):
    """Warnings on standard error, status 0; a refusal is status 2 and leaves no file."""
    for name, change, status in (("good", {}, 0), ("bad", {"m": 312600.0}, 2)):
        path, output = written(tmp_path, json.dumps(FULL | change), f"{name}.json"), tmp_path / f"{name}-model.json"
        arguments = ["import-model", str(path), "--family", "mmg", "--positive-rudder", "starboard", "-o", str(output)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert status_of(arguments) == status
        assert output.exists() is (status == 0)
    assert "m is 312600: 3.03e+08 to 3.22e+08 is usual" in capsys.readouterr().err
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        helmbench.read_parameters(tmp_path / "good.json", "mmg", positive_rudder="starboard")
    assert [one.category for one in told] == [RuntimeWarning] * 2
