"""HDF5 files and MAT files of version 7.3, read by h5py, and classic netCDF files, read by SciPy."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from .extras import needed

MOST_ITEMS, MOST_DEPTH, MOST_BYTES, MOST_NAMES = 10_000, 12, 2**31, 2000
UNIT_ATTRIBUTES = ("units", "unit", "Units", "Unit", "UNIT", "einheit")


def hdf_content(data: bytes, path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """(arrays and texts in nested dictionaries, path of an array -> its unit); links to other files are not followed.

    Raises
    ------
    BadInput : h5py is missing, or the file has too many groups.
    """
    h5py = needed("h5py", "h5py", "an HDF5 file (MAT version 7.3)", path)
    units: dict[str, str] = {}
    with h5py.File(io.BytesIO(data), "r") as file:
        return _group(h5py, file, "", units, [0]), units


def _group(h5py: Any, group: Any, where: str, units: dict[str, str], count: list[int]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for name in group:
        count[0] += 1
        if count[0] > MOST_ITEMS or where.count(".") >= MOST_DEPTH:
            raise BadInput("an HDF5 file with too many or too deep groups")
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink) or name.startswith("#"):
            continue
        item = group.get(name)
        if isinstance(item, h5py.Group):
            out[name] = _group(h5py, item, f"{where}.{name}".strip("."), units, count)
        elif isinstance(item, h5py.Dataset) and not item.is_virtual and not item.external and item.nbytes < MOST_BYTES:
            _take(h5py, where, name, item, out, units)
    return out


def _take(h5py: Any, where: str, name: str, item: Any, out: dict[str, Any], units: dict[str, str]) -> None:
    unit = next((text for key in UNIT_ATTRIBUTES if (text := text_of(item.attrs.get(key)))), "")
    if unit:
        units[f"{where}.{name}".strip(".")] = unit
    if text_of(item.attrs.get("MATLAB_class")) == "char":
        out[name] = "".join(map(chr, np.asarray(item[()]).ravel(order="F").astype(int).tolist()))
        return
    if item.dtype.names:
        table = item[()]
        out[name] = {field: table[field] for field in item.dtype.names}
    elif item.dtype.kind in "fiub":
        out[name] = unpacked(np.asarray(item[()]), item.attrs)
    elif h5py.check_string_dtype(item.dtype) is not None and item.size <= MOST_NAMES:
        out[name] = text_of(item[()]) if item.shape == () else np.array([text_of(one) for one in np.ravel(item[()])])


def unpacked(values: np.ndarray, stated: Mapping[str, Any]) -> np.ndarray:
    """The numbers of an array; packed ones by their attributes (Climate and Forecast conventions 1.11, section 8.1)."""
    packing = {name: stated[name] for name in ("scale_factor", "add_offset", "_FillValue") if name in stated}
    if not packing:
        return values
    numbers = {name: float(np.ravel(value)[0]) for name, value in packing.items()}
    real = values.astype(float) * numbers.get("scale_factor", 1.0) + numbers.get("add_offset", 0.0)
    return np.where(values == numbers["_FillValue"], np.nan, real) if "_FillValue" in numbers else real


def text_of(value: Any) -> str:
    """The text of an attribute; '' where it is none."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value if isinstance(value, str) else ""


# ---- Classic netCDF files, read by SciPy; those of version 4 are HDF5 files.


def netcdf_content(data: bytes) -> tuple[dict[str, Any], dict[str, str]]:
    """(arrays of a file, name of an array -> its unit)."""
    from scipy.io import netcdf_file

    content: dict[str, Any] = {}
    units: dict[str, str] = {}
    with netcdf_file(io.BytesIO(data), "r", mmap=False) as file:
        for name, variable in file.variables.items():
            stated = vars(variable)["_attributes"]
            content[name] = unpacked(np.array(variable[:]) if variable.shape else np.array(variable.data), stated)
            units[name] = next((text for key in UNIT_ATTRIBUTES if (text := text_of(stated.get(key)))), "")
    return content, {name: unit for name, unit in units.items() if unit}
