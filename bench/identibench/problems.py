"""The problems of an identification suite as HDF5 files, for identibench and programs that identify models of any kind.

    DIR/README.md              what there is, in words
    DIR/problems.json          each problem: its files, columns, steps and true parameters
    DIR/NAME/train/*.hdf5      training records: a dataset a channel, and attributes
    DIR/NAME/test/*.hdf5       held-out records

The folders are laid out as identibench's data sets are, but any program can read them.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, cast

from pydantic import ConfigDict, Field

from ...datasets.columns import CANONICAL, INPUTS, in_order
from ...datasets.record import Record
from ...estimation.validation.validate import TOGETHER
from ...models.argument_types import typed
from ...models.errors import BadInput
from ...models.extras import extras_told
from ...models.folders import make_folder, write_atomic
from ...models.plain import plain
from ...models.yaml_file import FileContent, Text, checked, load
from ..environment import code_version
from ..kinds import IDENTIFICATION, kind_of
from ..kinds.base import RunSelection, Suite
from ..kinds.identification.plan import RunSpec, task_key
from ..kinds.identification.problems import FitTask, Task, problem
from ..store import check_vacant
from ..suites import check_trust, load_suite
from .columns import RATE, SIDE

MANIFEST, README = "problems.json", "README.md"
TEXT = """# Problems of helmbench's suite {suite}

{title}: {count} problems, written by helmbench {version}.

`problems.json` lists them. A problem is a folder with training records in `train/` and held-out records in `test/`,
HDF5 files with one dataset a channel:

{channels}

`inputs` act on the ship and are known throughout; `outputs` are to be predicted on the held-out records from their
inputs and their first sample. Positions, where there are any, are beside them: they add up all errors of the others.
The heading is not wrapped. Gaps of the measurements are nan. A training record may have another step than the held-out
ones; the attribute `fs` of a file is its number of samples in a second, and is missing where the steps are unequal.
`positive_rudder` is the side to which a positive rudder turns the ship.

`truth` holds the true parameters of the model that helmbench fits, where there are any: those of the ship that was
simulated (`given`), or of its linearisation (`derived`); `crb_sd` is the Cramer-Rao bound of the standard deviation at
the noise of the training records. No method may be given them.

With identibench: `helmbench.identibench_specs(folder)` gives its benchmark specifications.
"""


@typed
def export_problems(
    suite: str,
    directory: str | PathLike[str],
    *,
    vessels: Sequence[str] = (),
    seeds: int | None = None,
) -> tuple[str, ...]:
    """Write the problems of an identification suite as HDF5 files, for identibench or any other program.

    A problem is what one row of the suite gives to a method: training and held-out records, and the model that is
    fitted.  Of several methods on the same records there is one problem.

    Parameters
    ----------
    suite : a name of `list_suites` or the path of a suite file, which may not name code.
    directory : new or empty; gets README.md, problems.json and a folder for each problem.
    vessels : only these vessels or measured sets.
    seeds : number of seeds; None: the suite's.

    Returns
    -------
    The problems' names, which are those of their folders.

    Raises
    ------
    BadInput : the suite is unknown, of another kind or names code, a measured set is missing, h5py is not installed, or
        the directory cannot be used.
    """
    out, found = Path(directory), load_suite(suite)
    check_vacant(out)
    if found.kind != IDENTIFICATION:
        raise BadInput(f"suite {found.name} identifies nothing", hint="its kind must be identification")
    check_trust(found.texts, suite, False)
    kind = kind_of(found.kind)
    specs = cast("Sequence[RunSpec]", kind.plan(found, RunSelection(suite, (), tuple(vessels), seeds)))
    kind.check(specs)
    tasks = list(dict.fromkeys(spec.task for spec in specs))
    with extras_told():
        import h5py  # noqa: F401, before anything is written
    width = len(str(len(tasks)))
    plain_names = [re.sub(r"[^A-Za-z0-9_-]+", "-", f"{task.vessel}-{task.model}")[:100] for task in tasks]
    named = {f"{i:0{width}}-{name}": task for i, (name, task) in enumerate(zip(plain_names, tasks, strict=True), 1)}
    entries = [_write(out, name, task) for name, task in named.items()]
    _write_head(out, found, entries)
    return tuple(named)


def _write(out: Path, name: str, task: Task) -> dict[str, Any]:
    """Write a problem's records; its entry of problems.json."""
    own = problem(task)
    files = {
        part: [_file(out, f"{name}/{part}/{part}-{i}.hdf5", record) for i, record in enumerate(records, start=1)]
        for part, records in (("train", own.train), ("test", own.held_out))
    }
    shared = in_order(set.intersection(*(set(record.channels) for record in (*own.train, *own.held_out))))
    return {
        "name": name,
        **task_key(task),
        "measured": task.measured,
        "inputs": [c for c in shared if c in INPUTS],
        "outputs": [c for c in shared if c in TOGETHER],
        "files": files,
        "truth": _truth(own),
    }


def _truth(own: FitTask) -> dict[str, Any]:
    truth = own.truth
    units = dict(zip(own.model.parameter_names, own.model.parameter_units, strict=True))
    return {
        name: {"value": value, "unit": units[name], "kind": truth.kind, "crb_sd": truth.crb_sd.get(name)}
        for name, value in truth.values.items()
    }


def _file(out: Path, name: str, record: Record) -> dict[str, Any]:
    """Write a record; what problems.json says of it."""
    path = out / name
    make_folder(path.parent)
    write_atomic(path, hdf5_bytes(record))
    return {"file": name, "record": record.name, "samples": record.n, "dt_s": record.dt}


def hdf5_bytes(record: Record) -> bytes:
    """A record as an HDF5 file: a dataset a column with its unit, and the attributes fs, positive_rudder and record."""
    import h5py

    columns = {name: record.column(name) for name in in_order(["time_s", *record.channels])}
    if "heading_rad" in columns:
        columns["heading_rad"] = record.heading_unwrapped()
    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        for name, values in columns.items():
            file.create_dataset(name, data=values).attrs["unit"] = CANONICAL[name]
        if record.uniform():
            file.attrs[RATE] = 1.0 / record.dt
        if record.meta.positive_rudder is not None:
            file.attrs[SIDE] = record.meta.positive_rudder
        file.attrs["record"] = record.name
    return memory.getvalue()


def _write_head(out: Path, suite: Suite, entries: Sequence[dict[str, Any]]) -> None:
    """README.md and problems.json."""
    used = in_order({"time_s", *(name for entry in entries for name in (*entry["inputs"], *entry["outputs"]))})
    facts = {"suite": suite.name, "title": suite.title, "version": code_version()}
    units = {name: CANONICAL[name] for name in used}
    content = {"schema_version": 1, **facts, "units": units, "problems": entries}
    channels = "\n".join(f"- `{name}`: {unit}" for name, unit in units.items())
    write_atomic(out / README, TEXT.format(count=len(entries), channels=channels, **facts).encode())
    write_atomic(out / MANIFEST, (json.dumps(plain(content), indent=1, allow_nan=False) + "\n").encode())


Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,120}$")]


class ProblemEntry(FileContent):
    """A problem: its folder, and the columns that are inputs and outputs; the other keys say what it is."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Name
    inputs: tuple[Text, ...] = Field(min_length=1)
    outputs: tuple[Text, ...] = Field(min_length=1)


class ProblemsFile(FileContent):
    """What problems.json holds."""

    schema_version: Literal[1]
    suite: Text
    title: Text
    version: Text
    units: dict[str, Any]
    problems: tuple[ProblemEntry, ...] = Field(min_length=1)


@typed
def identibench_specs(folder: str | PathLike[str], *, init_window: int = 1) -> list[Any]:
    """Exported problems as `BenchmarkSpec` of identibench: Simulation of the held-out records, metric rmse.

    The training records are `train` and, since there is no validation set, `train_valid`; `valid` is empty.

    Parameters
    ----------
    folder : what `export_problems` wrote.
    init_window : measured samples of a held-out record that a model is given, at least 1 for helmbench's methods.

    Returns
    -------
    A specification a problem, with the problem's name, inputs and outputs.

    Raises
    ------
    BadInput : identibench is not installed, the folder holds no problems, or init_window is negative.
    """
    if init_window < 0:
        raise BadInput(f"init_window is {init_window}, at least 0 is needed")
    place = Path(folder).absolute()
    if not (place / MANIFEST).is_file():
        raise BadInput("holds no exported problems", file=place, hint="write them with export_problems")
    found = checked(ProblemsFile, load(place / MANIFEST), place / MANIFEST)
    with extras_told():
        return [_spec(entry, place, init_window) for entry in found.problems]


def _spec(entry: ProblemEntry, place: Path, init_window: int) -> Any:
    from identibench import BenchmarkSpec, Simulation
    from identibench.metrics import rmse

    from .folder import Folder

    data = Folder(entry.name, None, root=place)
    train: list[tuple[Any, str]] = [(data, "train/*.hdf5")]
    metric: Any = rmse  # an array by channel, of which identibench takes the mean
    return BenchmarkSpec(
        name=entry.name,
        u_cols=list(entry.inputs),
        y_cols=list(entry.outputs),
        train=train,
        valid=[],
        train_valid=train,
        test_sets={"test": [(data, "test/*.hdf5")]},
        task=Simulation(metric=metric, init_window=init_window),
    )
