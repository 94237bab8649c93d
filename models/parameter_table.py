"""Published tables of parameters (name, value, unit) as models of a family.

Names may be spelled `Xu`, `X_u`, `X'_u`, `X_{\\dot u}` or `Xudot`.  A unit may state a scale, `1e-5`; one in the
heading of the values holds for numbers of unit 1 that have no unit beside them.  Of family abkowitz the masses may be
given by m', x_G', I_z' and the derivatives of the accelerations,

    m11 = m - X_udot   m22 = m - Y_vdot   m23 = m x_G - Y_rdot   m32 = m x_G - N_vdot   m33 = I_z - N_rdot

and terms that a table lacks are zero.  A table of mmgdynamics is read by `mmgdynamics.py`.  Numbers that no ship
has are refused, those that hardly any has are warned of (`parameter_checks.py`).
"""

from __future__ import annotations

import csv
import io
import math
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from . import kernels as kernel_store
from .errors import BadInput
from .files import read_utf8
from .mmgdynamics import NAMES, is_mmgdynamics, of_mmgdynamics
from .model import Model
from .number_texts import number_of
from .parameter_checks import MASS, check_model, doubts, ranges_of, with_gyration
from .particulars import STEPS
from .suggestions import suggestion
from .units import factor, si_factor
from .yaml_file import read_yaml

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
    content = read_yaml(path, "a table of parameters")
    entries = {str(name): entry for name, entry in content.items() if name != "comment"}
    fields = {name: entry if isinstance(entry, dict) else {"value": entry} for name, entry in entries.items()}
    return [
        _Entry(name, _number(own.get("value"), path, None, name), str(own.get("unit", "")))
        for name, own in fields.items()
    ]


def _of_csv(path: Path) -> list[_Entry]:
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
        number = number_of(value) if isinstance(value, str) else value
    except ValueError as error:
        raise BadInput(str(error), file=path, row=row, column=column) from None
    if isinstance(number, bool) or not isinstance(number, int | float) or not math.isfinite(number):
        raise BadInput(f"{str(value)[:80]!r} is not a finite number", file=path, row=row, column=column)
    return float(number)


def _by_known_name(
    entries: Iterable[_Entry], units: Mapping[str, str], path: Path
) -> tuple[dict[str, float], dict[str, int | None]]:
    """Known name -> number in its unit, and -> row."""
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
    return found, rows


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


def _units(family: str, kernels: kernel_store.Kernels) -> dict[str, str]:
    """Names that a table may have -> unit; empty: whatever it states, in SI units."""
    polynomial = family == "abkowitz"
    units = dict(zip(kernels.PARAMETERS, kernels.UNITS, strict=True))
    units |= dict.fromkeys(kernels.CONSTANTS, "1" if polynomial else "")
    return units | ({"L": "m", "U0": "m/s", **dict.fromkeys(PUBLISHED, "1")} if polynomial else {})


def _complete(stated: Mapping[str, float], family: str, kernels: kernel_store.Kernels, path: Path) -> dict[str, float]:
    """Every parameter and constant of a family by name; BadInput where one is missing."""
    values = dict(stated)
    if family == "abkowitz":
        values = dict.fromkeys(kernels.PARAMETERS, 0.0) | _with_masses(values, path)
    missing = [name for name in (*kernels.PARAMETERS, *kernels.CONSTANTS) if name not in values]
    if missing:
        raise BadInput(f"missing: {', '.join(missing)}", file=path, hint="add a row for each")
    return values


def _check(found: _Found, values: Mapping[str, float], family: str, path: Path) -> None:
    """Warn of numbers that hardly any ship has; BadInput for the first that none has."""
    numbers = with_gyration({**found.beside, **found.stated, **values})
    for doubt in doubts(numbers, (MASS, *ranges_of(family))):
        said = f"{found.names.get(doubt.name, doubt.name)} is {doubt.value:.6g}: {doubt.expected}"
        if doubt.impossible:
            row, hint = found.rows.get(doubt.name), "check its unit, sign and scale"
            raise BadInput(said, file=path, row=row, hint=hint)
        warnings.warn(f"{path.name}: {said}", RuntimeWarning, stacklevel=4)


@dataclass(frozen=True)
class _Found:
    """Numbers of a table by the names of the family, with the rows that they stand in; what else it says of the ship;
    names by which its reader knows them."""

    stated: Mapping[str, float]
    rows: Mapping[str, int | None]
    beside: Mapping[str, float] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)


def _found(entries: Sequence[_Entry], family: str, kernels: kernel_store.Kernels, path: Path) -> _Found:
    """A table's numbers; lines that tell how one of mmgdynamics was read are warnings."""
    if family != "mmg" or not is_mmgdynamics(entry.name for entry in entries):
        return _Found(*_by_known_name(entries, _units(family, kernels), path))
    own = of_mmgdynamics([(entry.name, entry.value, entry.unit, entry.row) for entry in entries], path)
    for line in own.told:
        warnings.warn(f"{path.name}: {line}", RuntimeWarning, stacklevel=4)
    return _Found(own.numbers, {}, own.beside, NAMES)


def model_of_table(
    path: Path, family: str, positive_rudder: str, speed_m_s: float | None, n0_rps: float | None
) -> Model:
    """The model of a table; see `helmbench.read_parameters`."""
    if family not in (known := kernel_store.catalogue()):
        raise BadInput(f"unknown family {family!r}", hint=suggestion(family, known))
    if positive_rudder not in ("port", "starboard"):
        raise BadInput(f"positive_rudder is {positive_rudder!r}", hint="port or starboard")
    for name, number in (("speed_m_s", speed_m_s), ("n0_rps", n0_rps)):
        if number is not None and not (math.isfinite(number) and number > 0.0):
            raise BadInput(f"{name} is {number!r}, a number above 0 is needed")
    kernels, entries = kernel_store.load(family), read_table(path)
    found = _found(entries, family, kernels, path)
    values = _complete(found.stated, family, kernels, path)
    _check(found, values, family, path)
    constants = np.array([values[name] for name in kernels.CONSTANTS])
    blank = Model(path.stem, family, np.full(len(kernels.COEFFICIENTS), np.nan), constants)
    model = blank.with_coefficients(blank.from_parameters({name: values[name] for name in kernels.PARAMETERS}))
    particulars = {"B": found.beside["B"], "L": values["L"], "d": values["d"]} if "B" in found.beside else {}
    speed = values.get("U0", math.nan) if speed_m_s is None else speed_m_s
    step = values["L"] / speed / STEPS if "L" in values and speed > 0.0 else model.max_step_s
    facts = {"speed_m_s": speed, "n0_rps": n0_rps, "max_step_s": step, "particulars": particulars, "source": path.name}
    model = replace(model, positive_rudder=positive_rudder, **facts)
    check_model(model, path)
    return model
