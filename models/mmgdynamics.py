"""Parameters of mmgdynamics (Paulig), and of other codes of the MMG standard method: tables of it, read and written.

Its places are in metres but x_H and l_R, its moment of inertia is about the centre of gravity, and the rudder stands at
half a length abaft midship: x_R' + a_H x_H' is kept by x_H'.  What mmgdynamics takes in the place of keys that a table
lacks is taken likewise (its module dynamics.py):

    no k_1 or k_2:  K_T = J_int + J_slo J           gamma_R:  on both sides, whatever gamma_R_plus and gamma_R_minus are
    no A_R:         A_R = (A_R/Ld_em) L d           no C_1, C_2:  w_P = w_P0 exp(-4 beta_P^2)

The last is no form of family mmg.  C_1 = 2 sqrt(ln 2) and C_2 = 1/(1 - w_P0) give the same wake on a straight course,
at large drift, and where it has fallen to half.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from .errors import BadInput
from .units import factor

if TYPE_CHECKING:
    from .model import Model

MARK = "R_0_dash"
"""Key by which such a table is known."""
SIZES = {"Lpp": "m", "B": "m", "d": "m", "x_G": "m", "x_P": "m", "D_p": "m", "A_R": "m2"}
SIZES |= {"m": "kg", "rho": "kg/m3", "I_zG": "kg m2"}
"""Units of the keys that have one."""
RUDDER_AT = -0.5
"""Longitudinal place of the rudder in lengths, which mmgdynamics takes for granted."""
_SAME = "w_P0 x_G l_R kappa epsilon t_P rho d f_alpha"
_HULL = "R_0 X_vv X_vr X_rr X_vvvv Y_v Y_r Y_vvv Y_vvr Y_vrr Y_rrr N_v N_r N_vvv N_vvr N_vrr N_rrr m_x m_y J_z"
AS_THEY_ARE, HULL = tuple(_SAME.split()), tuple(_HULL.split())
CURVE, WAKE, SIDES = ("k_0", "k_1", "k_2"), ("C_1", "C_2_plus", "C_2_minus"), ("gamma_R_plus", "gamma_R_minus")
CONVERTED = ("Lpp", "m", "I_zG", "D_p", "eta", "x_P", "t_R", "a_H", "x_H_dash")
RATIO_OF_RUDDER = ("A_R/Ld_em", "A_R_Ld_em")
HALF = 2.0 * math.sqrt(math.log(2.0))
NAMES = {
    "L": "Lpp", "D_P": "D_p", "mass": "m", "nabla": "displaced volume (of m and rho)", "x_P": "x_P/Lpp",
    "gyration": "radius of gyration (of I_zG)", "H_R": "rudder span (of D_p and eta)", "CRu": "1 - t_R",
    "CRv": "1 + a_H", "CRr": "place of the rudder's moment (of a_H and x_H_dash)",
} | {name: f"{name}_dash" for name in HULL}  # fmt: skip
"""Name in family mmg -> what a table's reader calls it."""
SLIPS = {("k_2", -0.1359): "Yasukawa & Yoshimura (2015) have -0.1385 for KVLCC2"}
"""Key and value -> what its source has."""


class MmgTable(NamedTuple):
    """Numbers of family mmg; what else the table says of the ship: B and C_b where it has them, mass in kg; lines that
    tell what was taken for keys that it lacks, slips of its source, and which keys were left out."""

    numbers: Mapping[str, float]
    beside: Mapping[str, float]
    told: list[str]


def is_mmgdynamics(names: Iterable[str]) -> bool:
    """Whether a table with these names is one of mmgdynamics."""
    return MARK in set(names)


def of_mmgdynamics(entries: Iterable[tuple[str, float, str, int | None]], file: object) -> MmgTable:
    """A table of names, values, units (empty: that of mmgdynamics) and rows.

    Raises
    ------
    BadInput : keys are missing or there twice, a unit is of another quantity, or Lpp, rho or eta is 0.
    """
    t = _in_si(entries, file)
    ratio = next((name for name in RATIO_OF_RUDDER if name in t and "A_R" not in t), "A_R")
    straight = {"J_int", "J_slo"} <= set(t) and not set(CURVE) <= set(t)
    near = t.get("w_P0", math.nan) < 1.0 and not set(WAKE) & set(t)
    asked = [*(("J_int", "J_slo") if straight else CURVE), *(() if near else WAKE)]
    asked += [*(["gamma_R"] if "gamma_R" in t else SIDES), ratio, *AS_THEY_ARE]
    asked += [*(f"{name}_dash" for name in HULL), *CONVERTED]
    if missing := [name for name in asked if name not in t]:
        hint = f"a table of mmgdynamics has {'it' if len(missing) == 1 else 'them'}"
        raise BadInput(f"missing: {', '.join(missing)}", file=file, hint=hint)
    out: dict[str, float] = {name: t[name] for name in (*AS_THEY_ARE, *CURVE, *WAKE, *SIDES) if name in asked}
    out |= {name: t[f"{name}_dash"] for name in HULL} | _converted(t, file)
    out["A_R"] = t[ratio] * (1.0 if ratio == "A_R" else t["Lpp"] * t["d"])
    told = []
    if straight:
        told.append("k_1 or k_2 is not there: K_T = J_int + J_slo J, as mmgdynamics has it")
        out |= {"k_0": t["J_int"], "k_1": t["J_slo"], "k_2": 0.0}
    if near:
        both = 1.0 / (1.0 - t["w_P0"])
        out |= dict(zip(WAKE, (HALF, both, both), strict=True))
        law = f"w_P = w_P0 exp(-4 beta_P^2), C_1 = {HALF:.3f} and C_2 = {both:.3f} are near it"
        told.append(f"C_1 and C_2 are not there: mmgdynamics then has {law}")
    if "gamma_R" in t:
        told.append(f"gamma_R is {t['gamma_R']:g}: it holds for both sides, as mmgdynamics has it")
        out |= dict.fromkeys(SIDES, t["gamma_R"])
    told += [f"{name} is {value:g}: {said}" for (name, value), said in SLIPS.items() if t.get(name) == value]
    left_out = [name for name in t if name not in (*asked, "B", "C_b")]
    told += [f"left out, not needed: {', '.join(left_out)}"] if left_out else []
    return MmgTable(out, {name: t[name] for name in ("B", "C_b") if name in t} | {"mass": t["m"]}, told)


def _in_si(entries: Iterable[tuple[str, float, str, int | None]], file: object) -> dict[str, float]:
    found: dict[str, float] = {}
    for name, value, unit, row in entries:
        if name in found:
            raise BadInput(f"{name} stands twice", file=file, row=row, column="name")
        own = SIZES.get(name, "1")
        try:
            found[name] = value * factor(unit or own, own)
        except ValueError as error:
            raise BadInput(f"{name}: {error}", file=file, row=row, column="unit") from None
    return found


def _converted(t: Mapping[str, float], file: object) -> dict[str, float]:
    """Places in lengths, moments about midship, and the rudder's factors: the inverse of `mmgdynamics`."""
    try:
        return {
            "L": t["Lpp"], "nabla": t["m"] / t["rho"], "I_zz": t["I_zG"] + t["m"] * t["x_G"] * t["x_G"],
            "D_P": t["D_p"], "H_R": t["D_p"] / t["eta"], "x_P": t["x_P"] / t["Lpp"],
            "CRu": 1.0 - t["t_R"], "CRv": 1.0 + t["a_H"], "CRr": RUDDER_AT + t["a_H"] * t["x_H_dash"],
        }  # fmt: skip
    except ZeroDivisionError:
        raise BadInput("Lpp, rho or eta is 0", file=file, hint="numbers above 0 are needed") from None


def mmgdynamics(model: Model) -> dict[str, str]:
    """File name -> text: a JSON object of the names and conventions of mmgdynamics.

    Raises
    ------
    BadInput : the model is not of the MMG standard method, or its breadth is not known.
    """
    from .export.equations import definition, heading, identifier, numbers

    definition(model)
    if model.family != "mmg":
        raise BadInput(f"{model.id} is of family {model.family}", hint="mmgdynamics takes family mmg alone")
    if "B" not in model.particulars:
        raise BadInput(f"{model.id}: the breadth B is missing", hint="add it to the particulars")
    c, breadth = numbers(model), model.particulars["B"]
    mass, increase = c["rho"] * c["nabla"], c["CRv"] - 1.0
    if increase == 0.0:
        raise BadInput(f"{model.id}: CRv is 1", hint="without a_H the place x_H has no value in mmgdynamics")
    table = {name: c[name] for name in (*AS_THEY_ARE, "A_R", *SIDES, *CURVE, *WAKE)}
    table |= {f"{name}_dash": c[name] for name in HULL}
    table |= {"Lpp": c["L"], "B": breadth, "C_b": c["nabla"] / (c["L"] * breadth * c["d"]), "m": mass}
    table |= {"I_zG": c["I_zz"] - mass * c["x_G"] ** 2, "D_p": c["D_P"], "eta": c["D_P"] / c["H_R"]}
    table |= {"x_P": c["x_P"] * c["L"], "t_R": 1.0 - c["CRu"], "a_H": increase}
    table |= {"x_H_dash": (c["CRr"] - RUDDER_AT) / increase}
    return {f"{identifier(model)}.json": json.dumps({"comment": heading(model), **table}, indent=2) + "\n"}
