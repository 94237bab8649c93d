"""A model of a craft from its records alone, and its diagnosis with page, figure and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..diagnosis.craft import result
from ..models.argument_types import typed
from .diagnosis import FILES, training_and_held_out
from .documents import write_result
from .identification import labels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..datasets.record import Record
    from .identification import Path as FilePath


class CraftDiagnosis(result.CraftDiagnosis):
    """The outcome of `build_model`: what steers the craft, what simpler models lack, how far ahead to trust the model.

    `model` is the model that was built, which `simulate`, `validate` and `diagnose` take like any other, `first` the
    steering law alone, `steps` the ladder, `ahead` the errors ahead, `band` how far heading can be trusted.
    """

    @classmethod
    def of(cls, found: result.CraftDiagnosis) -> CraftDiagnosis:
        """The same diagnosis with page, figure and files."""
        return cls(**{entry.name: getattr(found, entry.name) for entry in fields(found)})

    def to_html(self) -> str:
        """The page of the diagnosis: one self-contained HTML document."""
        from ..reporting.craft.page import html

        return html(self)

    def summary(self) -> str:
        """The diagnosis as text."""
        from ..reporting.craft.text import terminal

        return terminal(self)

    def plot(self, record: str | None = None) -> Figure:
        """Draw measured channels of a record with the free runs of both models over time.

        Parameters
        ----------
        record : name of a held-out record, or of a training record where none is held out; None: the first.

        Raises
        ------
        BadInput : there is no such record.
        """
        from .validation import runs_figure

        return runs_figure(self.ahead, record)

    def write(self, folder: FilePath) -> tuple[Path, ...]:
        """Write diagnosis.json, diagnosis.html and extended_model.json into a folder: all of them or none.

        Raises
        ------
        BadInput : the folder cannot be written to.
        """
        return write_result(Path(folder), FILES, self.to_json(), self.to_html(), self.model)

    def __repr__(self) -> str:
        return f"<CraftDiagnosis: {self.verdict}, {self.model.family}>"

    def _repr_html_(self) -> str:
        from ..models.figure import picture
        from ..reporting.craft.text import notebook

        return notebook(self) + picture(self.plot, "measured channels and free runs")


@typed
def build_model(
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    positive_rudder: str | None = None,
) -> CraftDiagnosis:
    """Build a model of a craft for which none is known, and say how far ahead it can be trusted.

    The records tell what steers the craft (a rudder in the flow, a rudder in a propeller's race, thrusters), and then
    one lack of the simpler model after the other: neutral angle, damping that grows with the yaw rate, delay, rate
    limit and lag, asymmetry, wind.  Models are fitted to short windows and judged by blocks of time that were left out.
    Measured speed, revolutions and wind are inputs.

    Parameters
    ----------
    train : one record or several, or paths of record files, with rudder or command, and heading or yaw rate.
    held_out : likewise; they take no part in the choice, but the model is not worse along them than the law alone.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Raises
    ------
    BadInput : a file cannot be used, a record is given twice or on both sides, or its numbers are in another unit than
        its columns say.
    CannotFit : the records hold no yaw motion, the rudder or command never moves, or all stretches are too short.
    """
    from ..diagnosis.craft.build import build
    from ..models.model import resolve

    records, others, doubts = training_and_held_out(resolve("nomoto-1"), train, held_out, positive_rudder)
    found = build(records, others)
    roles = [role for _, role in found.records]
    names = zip([*labels(train), *labels(held_out)], roles, strict=True)
    return CraftDiagnosis.of(replace(found, records=tuple(names), doubts=doubts))
