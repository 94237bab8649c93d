"""A table of mmgdynamics (Paulig), also as `export` writes it, in the names of family mmg.

What mmgdynamics takes in the place of keys that a table lacks is taken likewise (its module dynamics.py):

    no k_1 or k_2:  K_T = J_int + J_slo J           gamma_R:  on both sides, whatever gamma_R_plus and gamma_R_minus are
    no A_R:         A_R = (A_R/Ld_em) L d           no C_1, C_2:  w_P = w_P0 exp(-4 beta_P^2)

The last is no form of family mmg.  C_1 = 2 sqrt(ln 2) and C_2 = 1/(1 - w_P0) give the same wake on a straight course,
at large drift, and where it has fallen to half.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .errors import BadInput
from .export.mmgdynamics import HULL, RUDDER_AT
from .units import factor

MARK = "R_0_dash"
"""Key by which such a table is known."""
SIZES = {"Lpp": "m", "B": "m", "d": "m", "x_G": "m", "x_P": "m", "D_p": "m", "A_R": "m2"}
SIZES |= {"m": "kg", "rho": "kg/m3", "I_zG": "kg m2"}
"""Units of the keys that have one."""
AS_THEY_ARE = "w_P0 x_G l_R kappa epsilon t_P rho d f_alpha"
NEEDED = ("Lpp", "m", "I_zG", "D_p", "eta", "x_P", "t_R", "a_H", "x_H_dash", *AS_THEY_ARE.split())
RATIO_OF_RUDDER = ("A_R/Ld_em", "A_R_Ld_em")
HALF = 2.0 * math.sqrt(math.log(2.0))
NAMES = {
    "L": "Lpp", "D_P": "D_p", "mass": "m", "nabla": "displaced volume (of m and rho)", "x_P": "x_P/Lpp",
    "gyration": "radius of gyration (of I_zG)", "H_R": "rudder span (of D_p and eta)", "CRu": "1 - t_R",
    "CRv": "1 + a_H", "CRr": "place of the rudder's moment (of a_H and x_H_dash)",
} | {name: f"{name}_dash" for name in HULL.split()}  # fmt: skip
"""Name in family mmg -> what a table's reader calls it."""
SLIPS = {("k_2", -0.1359): "Yasukawa & Yoshimura (2015) have -0.1385 for KVLCC2"}
"""Key and value -> what its source has."""


@dataclass(frozen=True)
class Stated:
    """Numbers of family mmg; what else the table says of the ship: B and C_b where it has them, mass in kg; lines that
    tell what was taken for keys that it lacks, slips of its source, and which keys were left out."""

    numbers: Mapping[str, float]
    beside: Mapping[str, float]
    told: tuple[str, ...]


def is_mmgdynamics(names: Iterable[str]) -> bool:
    """Whether a table with these names is one of mmgdynamics."""
    return MARK in set(names)


def of_mmgdynamics(entries: Iterable[tuple[str, float, str, int | None]], file: object) -> Stated:
    """A table of names, values, units (empty: that of mmgdynamics) and rows.

    Raises
    ------
    BadInput : keys are missing or there twice, a unit is of another quantity, or Lpp, rho or eta is 0.
    """
    t = _AskedNumbers(_in_si(entries, file))
    told: list[str] = []
    out = _propeller(t, told) | _wake(t, told) | _straightening(t, told) | _rudder_area(t)
    out |= {name: t[name] for name in AS_THEY_ARE.split()} | {name: t[f"{name}_dash"] for name in HULL.split()}
    needed: dict[str, float] = {name: t[name] for name in NEEDED}
    if t.missing:
        hint = "a table of mmgdynamics has it" if len(t.missing) == 1 else "a table of mmgdynamics has them"
        raise BadInput(f"missing: {', '.join(t.missing)}", file=file, hint=hint)
    out |= _converted(needed, file)
    told += [f"{name} is {value:g}: {said}" for (name, value), said in SLIPS.items() if t.known.get(name) == value]
    beside = {name: t[name] for name in ("B", "C_b") if name in t.known} | {"mass": needed["m"]}
    left_out = [name for name in t.known if name not in t.used]
    told += [f"left out, not needed: {', '.join(left_out)}"] if left_out else []
    return Stated(out, beside, tuple(told))


class _AskedNumbers:
    """Numbers by key that remember which were asked for, and which of those are missing."""

    def __init__(self, known: Mapping[str, float]) -> None:
        self.known, self.used = known, set[str]()
        self.missing: list[str] = []

    def __getitem__(self, name: str) -> float:
        self.used.add(name)
        if name not in self.known and name not in self.missing:
            self.missing.append(name)
        return self.known.get(name, math.nan)

    def has(self, *names: str) -> bool:
        return all(name in self.known for name in names)


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


def _propeller(t: _AskedNumbers, told: list[str]) -> dict[str, float]:
    if t.has("J_int", "J_slo") and not t.has("k_0", "k_1", "k_2"):
        told.append("k_1 or k_2 is not there: K_T = J_int + J_slo J, as mmgdynamics has it")
        return {"k_0": t["J_int"], "k_1": t["J_slo"], "k_2": 0.0}
    return {name: t[name] for name in ("k_0", "k_1", "k_2")}


def _wake(t: _AskedNumbers, told: list[str]) -> dict[str, float]:
    names = ("C_1", "C_2_plus", "C_2_minus")
    if any(t.has(name) for name in names) or not t["w_P0"] < 1.0:
        return {name: t[name] for name in names}
    both = 1.0 / (1.0 - t["w_P0"])
    told.append(
        f"C_1 and C_2 are not there: mmgdynamics then has w_P = w_P0 exp(-4 beta_P^2), C_1 = {HALF:.3f} and C_2 = "
        f"{both:.3f} are near it"
    )
    return dict(zip(names, (HALF, both, both), strict=True))


def _straightening(t: _AskedNumbers, told: list[str]) -> dict[str, float]:
    sides = ("gamma_R_plus", "gamma_R_minus")
    if not t.has("gamma_R"):
        return {name: t[name] for name in sides}
    told.append(f"gamma_R is {t['gamma_R']:g}: it holds for both sides, as mmgdynamics has it")
    return dict.fromkeys(sides, t["gamma_R"])


def _rudder_area(t: _AskedNumbers) -> dict[str, float]:
    ratio = next((name for name in RATIO_OF_RUDDER if t.has(name)), None)
    return {"A_R": t["A_R"] if t.has("A_R") or ratio is None else t[ratio] * t["Lpp"] * t["d"]}


def _converted(t: Mapping[str, float], file: object) -> dict[str, float]:
    """Places in lengths, moments about midship, and the rudder's factors: the inverse of export/mmgdynamics.py."""
    try:
        return {
            "L": t["Lpp"], "nabla": t["m"] / t["rho"], "I_zz": t["I_zG"] + t["m"] * t["x_G"] * t["x_G"],
            "D_P": t["D_p"], "H_R": t["D_p"] / t["eta"], "x_P": t["x_P"] / t["Lpp"],
            "CRu": 1.0 - t["t_R"], "CRv": 1.0 + t["a_H"], "CRr": RUDDER_AT + t["a_H"] * t["x_H_dash"],
        }  # fmt: skip
    except ZeroDivisionError:
        raise BadInput("Lpp, rho or eta is 0", file=file, hint="numbers above 0 are needed") from None
