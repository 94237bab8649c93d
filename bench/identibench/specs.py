"""Problems that `export_problems` wrote as benchmark specifications of identibench."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from ...models.argument_types import typed
from ...models.errors import BadInput
from ...models.extras import extras_told
from ...models.yaml_file import FileContent, Text, checked, load
from .problems import MANIFEST

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
