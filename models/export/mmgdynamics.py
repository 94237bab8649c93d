"""The parameter table of mmgdynamics (Paulig), and of other codes of the MMG standard method."""

from __future__ import annotations

import json

from ..errors import BadInput
from ..model import Model
from .equations import definition, heading, identifier, numbers

RUDDER_AT = -0.5
"""Longitudinal place of the rudder in lengths, which mmgdynamics takes for granted."""
SAME = "w_P0 x_G l_R kappa A_R epsilon t_P rho d f_alpha gamma_R_plus gamma_R_minus k_0 k_1 k_2 C_1 C_2_plus C_2_minus"
HULL = "R_0 X_vv X_vr X_rr X_vvvv Y_v Y_r Y_vvv Y_vvr Y_vrr Y_rrr N_v N_r N_vvv N_vvr N_vrr N_rrr m_x m_y J_z"


def mmgdynamics(model: Model) -> dict[str, str]:
    """File name -> text: a JSON object of the names and conventions of mmgdynamics.

    Its places are in metres but x_H and l_R, its moment of inertia is about the centre of gravity, and the rudder
    stands at half a length abaft midship: x_R' + a_H x_H' is kept by x_H'.

    Raises
    ------
    BadInput : the model is not of the MMG standard method, or its breadth is not known.
    """
    definition(model)
    if model.family != "mmg":
        raise BadInput(f"{model.id} is of family {model.family}", hint="mmgdynamics takes family mmg alone")
    if "B" not in model.particulars:
        raise BadInput(f"{model.id}: the breadth B is missing", hint="add it to the particulars")
    c, breadth = numbers(model), model.particulars["B"]
    mass, increase = c["rho"] * c["nabla"], c["CRv"] - 1.0
    if increase == 0.0:
        raise BadInput(f"{model.id}: CRv is 1", hint="without a_H the place x_H has no value in mmgdynamics")
    table = {name: c[name] for name in SAME.split()} | {f"{name}_dash": c[name] for name in HULL.split()}
    table |= {"Lpp": c["L"], "B": breadth, "C_b": c["nabla"] / (c["L"] * breadth * c["d"]), "m": mass}
    table |= {"I_zG": c["I_zz"] - mass * c["x_G"] ** 2, "D_p": c["D_P"], "eta": c["D_P"] / c["H_R"]}
    table |= {"x_P": c["x_P"] * c["L"], "t_R": 1.0 - c["CRu"], "a_H": increase}
    table |= {"x_H_dash": (c["CRr"] - RUDDER_AT) / increase}
    return {f"{identifier(model)}.json": json.dumps({"comment": heading(model), **table}, indent=2) + "\n"}
