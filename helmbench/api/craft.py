"""A model of a craft from its records alone, and its diagnosis with page, figure and files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnosis.craft.result import CraftDiagnosis
from ..models.argument_types import typed
from .arguments import as_model, labels
from .diagnosis import READING, shown_stages, training_and_held_out

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .arguments import Path as FilePath


@typed
def build_model(
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    positive_rudder: str | None = None,
    particulars: Model | FilePath | None = None,
    progress: bool | Callable[[str], object] = False,
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
    particulars : YAML file of the ship's particulars (docs/mathematics/craft.md), or another simulation of surge, sway
        and yaw: it is corrected by the training records and told beside the built model, `ship` of the outcome.
    progress : show on standard error which stage it is in; or a function that is called with every stage when it
        begins.

    Raises
    ------
    BadInput : a file cannot be used, a record is given twice or on both sides, or its numbers are in another unit than
        its columns say.
    CannotFit : the records hold no yaw motion, the rudder or command never moves, or all stretches are too short.
    """
    from ..models.cache import FIRST_USE

    with shown_stages(progress) as watch, FIRST_USE.told_to(watch):
        watch(READING)
        from ..diagnosis.craft.build import build
        from ..models.model import resolve

        ship = None if particulars is None else as_model(particulars)
        records, others, doubts = training_and_held_out(resolve("nomoto-1"), train, held_out, positive_rudder)
        found = build(records, others, ship, watch)
    roles = [role for _, role in found.records]
    names = zip([*labels(train), *labels(held_out)], roles, strict=True)
    return replace(found, records=tuple(names), doubts=doubts)
