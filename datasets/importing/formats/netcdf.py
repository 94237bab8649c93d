"""Classic netCDF files, read by SciPy; those of version 4 are HDF5 files."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from .hdf import UNIT_ATTRIBUTES, text_of, unpacked


def netcdf_content(data: bytes, path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """(arrays of a file, name of an array -> its unit).

    Raises
    ------
    BadInput : the file is damaged.
    """
    from scipy.io import netcdf_file

    content: dict[str, Any] = {}
    units: dict[str, str] = {}
    try:
        with netcdf_file(io.BytesIO(data), "r", mmap=False) as file:
            for name, variable in file.variables.items():
                stated = vars(variable)["_attributes"]
                content[name] = unpacked(np.array(variable[:]) if variable.shape else np.array(variable.data), stated)
                units[name] = next((text for key in UNIT_ATTRIBUTES if (text := text_of(stated.get(key)))), "")
    except MemoryError:
        raise
    except Exception as error:  # whatever SciPy raises on damaged files
        raise BadInput(f"not a netCDF file that can be read ({type(error).__name__})", file=path) from None
    return content, {name: unit for name, unit in units.items() if unit}
