"""identibench's ship set as records and a suite of helmbench."""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path

import numpy as np
import yaml

from ...datasets.importing.binary_tables import hdf_content
from ...datasets.io import write_record
from ...datasets.record import Record, RecordMeta
from ...models.argument_types import typed
from ...models.errors import BadInput
from ...models.files import read_bytes
from ...models.folders import make_folder, write_atomic
from ..store import check_vacant
from .columns import SHIP_INPUTS, SHIP_OUTPUTS, SHIP_POSITIVE_RUDDER, SHIP_STEP_S, record_of

ROOT_VARIABLE, DEFAULT_ROOT = "IDENTIBENCH_DATA_ROOT", ".identibench_data"
PARTS = ("train", "test", "test_ood")
SUITE_FILE = "suite.yaml"
TITLE = "identibench's ship set: a simulated patrol ship in wind and waves, at 1 Hz"
MODELS = ["nomoto-1-cubic", "nomoto-2-cubic"]
META = RecordMeta(
    vessel="patrol ship",
    source="Baier & Staab 2022, doi 10.18419/darus-2905, as identibench prepares it",
    positive_rudder=SHIP_POSITIVE_RUDDER,
    notes="simulated; the rudder is the mean of both rudders; its sign is assumed; the wind's angle and the waves are "
    "left out",
)


@typed
def identibench_suite(directory: str | PathLike[str], data_root: str | PathLike[str] | None = None) -> Path:
    """Write identibench's ship set as records, with a suite file that runs every method on them.

    The training records are identibench's `train`; the held-out ones `test` in one row and the out-of-distribution
    set `test_ood` in another.  `valid` is left out: helmbench's methods choose by their training records.

    Parameters
    ----------
    directory : new or empty; gets train/, test/, test_ood/ and suite.yaml.
    data_root : folder of identibench's data, which has ship/; None: the one that the environment variable
        IDENTIBENCH_DATA_ROOT names, else ~/.identibench_data.

    Returns
    -------
    Path of the suite file, for `run_suite`.

    Raises
    ------
    BadInput : the set is not there, h5py is missing, a file lacks a column, or the directory cannot be used; nothing
        is written unless all files can be read.
    """
    folder, out = (Path(data_root) if data_root else default_root()) / "ship", Path(directory)
    check_vacant(out)
    files = {part: sorted((folder / part).glob("*.hdf5")) for part in PARTS}
    empty = next((part for part, found in files.items() if not found), None)
    if empty is not None:
        hint = "identibench downloads it: identibench.datasets.ship_dataset.ensure_exists(), with identibench[ship]"
        raise BadInput("has no file of identibench's ship set", file=folder / empty, hint=hint)
    records = {f"{part}/{path.stem}.csv": ship_record(path) for part, found in files.items() for path in found}
    for part in PARTS:
        make_folder(out / part)
    for name, record in records.items():
        write_record(record, out / name)
    write_atomic(out / SUITE_FILE, _suite_text(list(records)).encode())
    return out / SUITE_FILE


def default_root() -> Path:
    """identibench's folder of data; an empty variable counts as unset."""
    return Path(os.environ.get(ROOT_VARIABLE) or Path.home() / DEFAULT_ROOT)


def ship_record(path: Path) -> Record:
    """One file of the ship set as a record.

    Raises
    ------
    BadInput : the file cannot be read, h5py is missing, or a column is missing or of another length.
    """
    try:
        content, _ = hdf_content(read_bytes(path))
    except BadInput:
        raise
    except Exception:  # whatever h5py raises on damaged files
        raise BadInput("not an HDF5 file that can be read", file=path, hint="is it whole?") from None
    columns = {name: _column(content, name, path) for name in (*SHIP_INPUTS, *SHIP_OUTPUTS)}
    if len({values.size for values in columns.values()}) > 1:
        raise BadInput("its columns have unequal lengths", file=path)
    return record_of(columns, SHIP_STEP_S, path.stem, META)


def _column(content: dict[str, object], name: str, path: Path) -> np.ndarray:
    values = content.get(name)
    if not isinstance(values, np.ndarray) or values.ndim != 1 or values.dtype.kind not in "fiu" or not values.size:
        raise BadInput("missing column of numbers", file=path, column=name)
    return values.astype(float)


def _suite_text(names: list[str]) -> str:
    parts = {part: [name for name in names if name.startswith(f"{part}/")] for part in PARTS}
    records = {"train": [parts["train"]], "held_out": [parts["test"], parts["test_ood"]], "ship": "identibench-ship"}
    entry = {"records": records, "models": MODELS, "methods": ["all"]}
    return yaml.safe_dump({"title": TITLE, "entries": [entry]}, sort_keys=False, allow_unicode=True)
