"""Published tables of parameters (name, value, unit) as models of a family.

Names may be spelled `Xu`, `X_u`, `X'_u`, `X_{\\dot u}` or `Xudot`.  A unit may state a scale, `1e-5`; one in the
heading of the values holds for numbers of unit 1 that have no unit beside them.  Of family abkowitz the masses may be
given by m', x_G', I_z' and the derivatives of the accelerations,

    m11 = m - X_udot   m22 = m - Y_vdot   m23 = m x_G - Y_rdot   m32 = m x_G - N_vdot   m33 = I_z - N_rdot

and terms that a table lacks are zero.  A table of mmgdynamics, as `export` writes it, is read back likewise.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import kernels as kernel_store
from .errors import BadInput
from .export.mmgdynamics import RUDDER_AT
from .particulars import STEPS
from .suggestions import suggestion

if TYPE_CHECKING:
    from .model import Model

MASSES = {
    "m11": "m - Xudot",
    "m22": "m - Yvdot",
    "m23": "m*xG - Yrdot",
    "m32": "m*xG - Nvdot",
    "m33": "Iz - Nrdot",
}
"""Masses of family abkowitz -> how published numbers give them, all primes."""
PUBLISHED = ("m", "xG", "Iz", "Xudot", "Yvdot", "Yrdot", "Nvdot", "Nrdot")
_SCALE = re.compile(r"(?:[x*×]\s*)?(?:1e|10\s*\^\s*\{?|1\.0*e)\s*([-+−]?\d+)\}?$", re.IGNORECASE)


@dataclass(frozen=True)
class _Entry:
    """One number of a table; row None in YAML and JSON."""

    name: str
    value: float
    unit: str
    row: int | None = None
    heading_scale: float = 1.0


def plain(name: str) -> str:
    """A coefficient's name without the marks of its spelling: `X'_{\\dot u}` -> `Xudot`, `N_{v\\delta}` -> `Nvd`."""
    text = re.sub(r"\\dot\s*\{?\s*([a-z])\s*\}?", r"\1dot", name)
    text = text.replace("\\delta", "d").replace("δ", "d").replace("\\prime", "")
    return re.sub(r"[\s_{}$^'′\u2019,\\]", "", text)


def scale_of(text: str) -> float | None:
    """The power of ten that `1e-5`, `x 10^-5` or a heading `value (1e-5)` states; None where there is none that a
    number can have."""
    found = _SCALE.search(text.strip().rstrip(")]").strip())
    power = float(f"1e{found[1].replace('−', '-')}") if found else 0.0
    return power if 0.0 < power < math.inf else None


def read_table(path: Path) -> list[_Entry]:
    """The numbers of a CSV, YAML or JSON table; BadInput names row and column."""
    if path.suffix.lower() == ".csv":
        return _of_csv(path)
    from .yaml_file import read_yaml

    content = read_yaml(path, "a table of parameters")
    return [_of_key(str(name), entry, path) for name, entry in content.items() if name != "comment"]


def _of_key(name: str, entry: object, path: Path) -> _Entry:
    """A number, or a mapping with value and unit, of a YAML or JSON table."""
    fields = entry if isinstance(entry, dict) else {"value": entry}
    return _Entry(name, _number(fields.get("value"), path, None, name), str(fields.get("unit", "")))


def _of_csv(path: Path) -> list[_Entry]:
    from .files import read_utf8

    reader = csv.reader(io.StringIO(read_utf8(path).decode()))
    try:
        header, *rows = [(reader.line_num, cells) for cells in reader] or [(1, [])]
    except csv.Error as error:
        raise BadInput(f"is no CSV: {error}", file=path, row=reader.line_num) from None
    header = [cell.strip() for cell in header[1]]
    places = {
        word: next((i for i, cell in enumerate(header) if cell.lower().startswith(word)), None)
        for word in ("name", "value", "unit")
    }
    at, value_at, unit_at = places.values()
    if at is None or value_at is None:
        raise BadInput("needs the columns name and value", file=path, row=1, hint="a third, unit, may follow")
    scale, found = scale_of(header[value_at]) or 1.0, []
    for row, cells in rows:
        if not any(cell.strip() for cell in cells):
            continue
        cells = cells + [""] * (len(header) - len(cells))
        value = _number(cells[value_at].strip().replace("−", "-"), path, row, header[value_at])
        found.append(_Entry(cells[at].strip(), value, "" if unit_at is None else cells[unit_at].strip(), row, scale))
    return found


def _number(value: object, path: Path, row: int | None, column: str) -> float:
    try:
        number = float(value) if isinstance(value, str | int | float) and not isinstance(value, bool) else math.nan
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadInput(f"{str(value)!r} is no finite number", file=path, row=row, column=column)
    return number


def _by_known_name(entries: Iterable[_Entry], units: Mapping[str, str], path: Path) -> dict[str, float]:
    """Known name -> number in its unit."""
    from .units import factor, si_factor

    known, found, rows = {plain(name): name for name in units}, {}, {}
    for entry in entries:
        name = known.get(plain(entry.name))
        if name is None:
            hint = suggestion(plain(entry.name), known)
            raise BadInput(f"unknown parameter {entry.name!r}", file=path, row=entry.row, column="name", hint=hint)
        if name in found:
            also = f" (also in row {rows[name]})" if rows[name] else ""
            raise BadInput(f"{name} stands twice{also}", file=path, row=entry.row, column="name")
        scale = (scale_of(entry.unit) if entry.unit else entry.heading_scale) if units[name] == "1" else None
        if scale is None:
            try:
                unit = units[name]
                scale = factor(entry.unit or unit, unit) if unit else si_factor(entry.unit)
            except ValueError as error:
                raise BadInput(f"{name}: {error}", file=path, row=entry.row, column="unit") from None
        found[name], rows[name] = scale * entry.value, entry.row
    return found


def _with_masses(values: dict[str, float], path: Path) -> dict[str, float]:
    """m11 ... m33 of family abkowitz from the published numbers, where they do not stand there themselves."""
    given = {name: values.pop(name) for name in PUBLISHED if name in values}
    for mass, formula in MASSES.items():
        body, derivative = formula.split(" - ")
        needed = [*body.split("*"), derivative]
        if mass in values and derivative in given:
            raise BadInput(
                f"both {mass} and {derivative} stand there", file=path, hint=f"{mass} is {formula}: give one"
            )
        if mass not in values:
            missing = [name for name in needed if name not in given]
            if missing:
                hint = f"give {mass}, or {', '.join(needed)}"
                raise BadInput(f"missing: {mass} = {formula} needs {', '.join(missing)}", file=path, hint=hint)
            values[mass] = math.prod(given[name] for name in body.split("*")) - given[derivative]
    return values


def _of_mmgdynamics(entries: Iterable[_Entry], path: Path) -> list[_Entry]:
    """A table of mmgdynamics in the names of family mmg (the inverse of export/mmgdynamics.py)."""
    t = {entry.name: entry.value for entry in entries}
    try:
        out = {name.removesuffix("_dash"): value for name, value in t.items()}
        out |= {"L": t["Lpp"], "nabla": t["m"] / t["rho"], "I_zz": t["I_zG"] + t["m"] * t["x_G"] ** 2}
        out |= {"D_P": t["D_p"], "H_R": t["D_p"] / t["eta"], "x_P": t["x_P"] / t["Lpp"]}
        out |= {"CRu": 1.0 - t["t_R"], "CRv": 1.0 + t["a_H"], "CRr": RUDDER_AT + t["a_H"] * t["x_H_dash"]}
    except KeyError as error:
        raise BadInput(f"missing: {error.args[0]}", file=path, hint="a table of mmgdynamics has it") from None
    except ZeroDivisionError:
        raise BadInput("Lpp, rho or eta is 0", file=path, hint="numbers above 0 are needed") from None
    dropped = ("Lpp", "B", "C_b", "m", "I_zG", "D_p", "eta", "t_R", "a_H", "x_H")
    return [_Entry(name, value, "") for name, value in out.items() if name not in dropped]


def _values(entries: Iterable[_Entry], family: str, kernels: kernel_store.Kernels, path: Path) -> dict[str, float]:
    """Every parameter and constant of a family by name, in its unit; BadInput where one is missing."""
    polynomial = family == "abkowitz"
    units = dict(zip(kernels.PARAMETERS, kernels.UNITS, strict=True))
    units |= dict.fromkeys(kernels.CONSTANTS, "1" if polynomial else "")
    units |= {"L": "m", "U0": "m/s", **dict.fromkeys(PUBLISHED, "1")} if polynomial else {}
    values = _by_known_name(entries, units, path)
    if polynomial:
        values = dict.fromkeys(kernels.PARAMETERS, 0.0) | _with_masses(values, path)
    missing = [name for name in (*kernels.PARAMETERS, *kernels.CONSTANTS) if name not in values]
    if missing:
        raise BadInput(f"missing: {', '.join(missing)}", file=path, hint="add a row for each")
    for name in {"L", "U0"} & set(kernels.CONSTANTS):
        if not values[name] > 0.0:
            raise BadInput(f"{name} is {values[name]:g}, a number above 0 is needed", file=path)
    return values


def model_of_table(
    path: Path, family: str, positive_rudder: str, speed_m_s: float | None, n0_rps: float | None
) -> Model:
    """The model of a table; see `helmbench.read_parameters`."""
    from .model import Model

    if family not in (known := kernel_store.catalogue()):
        raise BadInput(f"unknown family {family!r}", hint=suggestion(family, known))
    if positive_rudder not in ("port", "starboard"):
        raise BadInput(f"positive_rudder is {positive_rudder!r}", hint="port or starboard")
    for name, number in (("speed_m_s", speed_m_s), ("n0_rps", n0_rps)):
        if number is not None and not (math.isfinite(number) and number > 0.0):
            raise BadInput(f"{name} is {number!r}, a number above 0 is needed")
    kernels, entries = kernel_store.load(family), read_table(path)
    mmgdynamics = family == "mmg" and any(entry.name == "R_0_dash" for entry in entries)
    values = _values(_of_mmgdynamics(entries, path) if mmgdynamics else entries, family, kernels, path)
    constants = np.array([values[name] for name in kernels.CONSTANTS])
    blank = Model(path.stem, family, np.full(len(kernels.COEFFICIENTS), np.nan), constants)
    model = blank.with_coefficients(blank.from_parameters({name: values[name] for name in kernels.PARAMETERS}))
    breadth = [entry.value for entry in entries if entry.name == "B"]
    particulars = {"B": breadth[-1], "L": values["L"], "d": values["d"]} if mmgdynamics and breadth else {}
    speed = values.get("U0", math.nan) if speed_m_s is None else speed_m_s
    step = values["L"] / speed / STEPS if "L" in values and speed > 0.0 else model.max_step_s
    facts = {"speed_m_s": speed, "n0_rps": n0_rps, "max_step_s": step, "particulars": particulars, "source": path.name}
    return replace(model, positive_rudder=positive_rudder, **facts)
