"""Numbers as vessel and model files state them: in SI units, in the order of a family, parameters as coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import BadInput
from .instruments import INSTRUMENTS, checked
from .kernels import Kernels
from .units import factor, si_factor

Stated = Mapping[str, tuple[float | None, str]]
"""Name -> value, None where it is not known, and unit."""


def public_of(kernels: Kernels, coefficients: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Published parameters (q,) of coefficients (p,), and d parameters / d coefficients (q, p)."""
    values = np.array(coefficients, float)
    if not kernels.PUBLISHED:
        return values, np.eye(values.size)
    parameters = np.empty(len(kernels.PARAMETERS))
    jacobian = np.zeros((parameters.size, values.size))
    kernels.public(values, parameters, jacobian)
    return parameters, jacobian


def coefficients_of(kernels: Kernels, parameters: ArrayLike | Mapping[str, float]) -> NDArray[np.float64]:
    if isinstance(parameters, Mapping):
        parameters = [parameters[name] for name in kernels.PARAMETERS]
    values = np.array(parameters, float)
    if not kernels.PUBLISHED:
        return values
    coefficients = np.empty(len(kernels.COEFFICIENTS))
    kernels.private(values, coefficients)
    return coefficients


def parameters_of(stated: Stated, kernels: Kernels, file: object) -> dict[str, float]:
    """Published parameters in the family's units; BadInput for another unit."""
    units = dict(zip(kernels.PARAMETERS, kernels.UNITS, strict=True))
    return _converted(stated, units, "parameters", file)


def stated_coefficients(
    coefficients: Mapping[str, float | None] | None, parameters: Mapping[str, float], kernels: Kernels, file: object
) -> NDArray[np.float64]:
    """Coefficients (p,) as a file states them, or those of its parameters; BadInput where the two differ, or
    where some have no number."""
    if coefficients is None:
        stated = in_order(parameters, kernels.PARAMETERS, file, "parameter")
        values = coefficients_of(kernels, stated)
        if np.isnan(values).any():
            _refuse_gaps(stated, kernels.PARAMETERS, file, "parameter")
        return values
    values = in_order(coefficients, kernels.COEFFICIENTS, file, "coefficient")
    _refuse_gaps(values, kernels.COEFFICIENTS, file, "coefficient")
    if parameters:
        stated, own = in_order(parameters, kernels.PARAMETERS, file, "parameter"), public_of(kernels, values)[0]
        own = np.where(np.isfinite(own), own, np.nan)  # what has no finite value is stated as null
        differs = ~np.isclose(stated, own, rtol=1e-6, atol=0.0, equal_nan=True)
        if differs.any():
            i = int(differs.argmax())
            said = f"parameters {kernels.PARAMETERS[i]} is {stated[i]:.6g}, the coefficients give {own[i]:.6g}"
            raise BadInput(said, file=file, hint="to change parameters, leave the block coefficients out")
    return values


def _refuse_gaps(values: NDArray[np.float64], names: Sequence[str], file: object, kind: str) -> None:
    """BadInput where some, but not all, of the values (p,) are nan."""
    unknown = [name for name, value in zip(names, values, strict=True) if np.isnan(value)]
    if 0 < len(unknown) < values.size:
        hint = f"give every {kind} a number, or none (null) to have all of them identified"
        raise BadInput(f"{kind}s without a number: {', '.join(unknown)}", file=file, hint=hint)


def instruments_of(stated: Stated, file: object) -> dict[str, float]:
    """Numbers of `Model.instruments` in SI units and radians; BadInput for an unknown one or another unit."""
    return checked(_converted(stated, INSTRUMENTS, "instruments", file), file)


def in_si(entries: Mapping[str, Mapping] | None) -> dict[str, float]:
    """Numbers with units, in SI units and radians."""
    return {name: float(entry["value"]) * si_factor(entry["unit"]) for name, entry in (entries or {}).items()}


def in_order(entries: Mapping[str, float | None], names: Sequence[str], file: object, kind: str) -> NDArray[np.float64]:
    """Numbers by name in the order of `names`, nan for None; BadInput where names are missing or unknown."""
    missing = [name for name in names if name not in entries]
    extra = [name for name in entries if name not in names]
    if missing or extra:
        said = f"{kind}s missing: {', '.join(missing)}" if missing else f"unknown {kind}s: {', '.join(extra)}"
        raise BadInput(said, file=file, hint=f"the family has {', '.join(names)}")
    return np.array([_number(entries[name]) for name in names])


def _converted(stated: Stated, units: Mapping[str, str], block: str, file: object) -> dict[str, float]:
    found = {}
    for name, (value, unit) in stated.items():
        try:
            found[name] = _number(value) * factor(unit, units.get(name, unit))
        except ValueError as error:
            raise BadInput(f"{block} {name}: {error}", file=file) from None
    return found


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
