"""What a worker process does: reads logs as records, and checks, identifies or diagnoses parts of them."""

from __future__ import annotations

import json
import re
import signal
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.plain import plain

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import numpy as np

    from .. import ImportDraft
    from ..datasets.record import Record
    from .recipes import Recipe

TAKE_TIME = ("numba", "scipy.signal", "..reporting.open.views")
"""Modules that the tasks need: imported while there is none, so that the next begins at once."""
Stage = Callable[[str], object]
"""Is called with what begins now, in words."""
VIEW, RECORDS, MAP, COLUMNS = "view.json", "records", "log.map.yaml", "columns.json"
NO_MODEL = ""
"""Stands for a ship of which no simulation is known."""
DRAWN = 300
"""Samples of a column that are drawn."""
READING_STEPS = 4
"""Stages of a reading: the start of the process and those that `read_logs` tells."""


def steps_of(kind: str, model: str) -> int:
    """The most stages of an analysis, the start of its process among them."""
    return {"check": 4, "identify": 5, "diagnose": 7 if model == NO_MODEL else 9}[kind]


def work(pipe: Connection) -> None:
    """Do tasks until the server is gone: takes (name, arguments), sends stages and then one outcome."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's, which ends this process
    ahead = list(TAKE_TIME)
    while True:
        try:
            while ahead and not pipe.poll():
                import_module(ahead.pop(0), __package__)
            name, arguments = pipe.recv()
            pipe.send(outcome(name, arguments, lambda text: pipe.send(("stage", text))))
        except (EOFError, OSError):
            return


def outcome(name: str, arguments: Mapping[str, Any], stage: Stage) -> tuple[str, Any]:
    """('done', result), or ('refused' or 'failed', one line that says why)."""
    try:
        return "done", plain(TASKS[name](stage=stage, **arguments))
    except (BadInput, CannotFit, FitFailed) as error:
        return "refused", _line(error, arguments["out"])
    except MemoryError as error:
        return "refused", f"not enough memory ({error or 'the machine refused more'})"
    except OSError as error:
        return "failed", f"the system refused it: {error.strerror or error}"
    except Exception as error:  # a fault of ours must not end the page
        return "failed", f"this is a fault of helmbench ({type(error).__name__}: {error}); please report it"


def _line(error: Exception, out: str) -> str:
    """One line without the folders of the project, in which `out` is."""
    folder = re.escape(str(Path(out).parent))
    return re.sub(rf"{folder}[/\\](?:[\w-]+[/\\])*", "", " ".join(str(error).split()))


# ------------------------------------------------------------------------------------------------ logs


def read_logs(
    logs: str,
    files: Sequence[str],
    mapping: str | None,
    out: str,
    answers: Mapping[str, str],
    choices: Sequence[tuple[str, str, Mapping[str, Any]]],
    positive_rudder: str | None,
    stage: Stage,
) -> dict[str, Any]:
    """Read logs as records, which are written into `out` with what the page draws of them.

    logs : folder of the files.  mapping : path of a mapping that was dropped with them.  answers : id of a question ->
    key of its answer.  choices : (table, column, what the user says of it: `to`, `unit`, `sign`).

    Returns
    -------
    Questions, columns, steps, faults, records and parts; `line` says why there is no record.

    Raises
    ------
    BadInput : an answer or a choice cannot be.
    """
    from .. import draft_import

    stage("reading the log" if len(files) == 1 else f"reading {len(files)} logs")
    empty = ("questions", "columns", "records", "parts", "steps", "faults")
    found: dict[str, Any] = {"line": "", **{name: [] for name in empty}}
    try:
        draft = draft_import([Path(logs, name) for name in files], mapping=mapping, positive_rudder=positive_rudder)
    except BadInput as error:
        return found | {"line": _line(error, out), "faults": _faults(error)}
    draft = _told(draft, answers, choices)
    stage("drawing the columns")
    found |= {"questions": plain(draft.questions), "columns": _columns(draft), "faults": _faults(draft)}
    Path(out, COLUMNS).write_text(json.dumps(_drawn(draft)), "utf-8")
    if draft.questions:
        open_ones = f"{len(draft.questions)} question{'s are' if len(draft.questions) > 1 else ' is'} open"
        return found | {"line": open_ones}
    stage("making the records")
    try:
        log = draft.import_log()
    except BadInput as error:
        return found | {"line": _line(error, out), "faults": _faults(error)}
    log.write_mapping(Path(out, MAP), force=True)
    found |= {"steps": list(log.report.steps), "faults": _faults(log.report)}
    return found | _stored(log.records, Path(out))


def _told(
    draft: ImportDraft, answers: Mapping[str, str], choices: Sequence[tuple[str, str, Mapping[str, Any]]]
) -> ImportDraft:
    """The draft with what the user says of it; BadInput where that cannot be."""
    draft = draft.answer(answers)
    if not choices or draft.mapping is None:
        return draft
    return draft.with_columns({(table, column): said for table, column, said in choices})


def _faults(found: Any) -> list[dict[str, Any]]:
    return [vars(fault) for fault in getattr(found, "faults", ())]


def _columns(draft: ImportDraft) -> list[dict[str, Any]]:
    """A row a column for the page, with the factor, 1 or -1, that its sign is read with, and how it was sampled."""
    turned = draft.turned_columns()
    timed = {row.table for row in draft.columns if row.quantity == "time" and row.unit}
    rows: list[dict[str, Any]] = plain(draft.columns)
    return [
        row | {"factor": -1 if (row["table"], row["column"]) in turned else 1}
        | sampling(*draft.series(row["table"], row["column"]), row["table"] in timed)
        for row in rows
    ]  # fmt: skip


def sampling(time: np.ndarray, values: np.ndarray, timed: bool) -> dict[str, Any]:
    """Rows of a column (N,), the share of them without a number, and the numbers a second, None where no time is known.

    time : (N,), s, or row numbers where not `timed`.
    """
    import numpy as np

    known = np.isfinite(values) & np.isfinite(time)
    steps = np.diff(time[known])
    step = float(np.median(steps)) if timed and steps.size else 0.0
    missing = 1.0 - float(np.isfinite(values).mean()) if values.size else 0.0
    return {"rows": values.size, "missing": missing, "rate": 1.0 / step if step > 0.0 else None}


def _drawn(draft: ImportDraft) -> list[dict[str, Any]]:
    """The numbers of every column of the logs, as they stand, over time, s, or row numbers where it does not rise."""
    import numpy as np

    from ..reporting.open.views import envelope, numbers

    found: list[dict[str, Any]] = []
    for one in draft.columns:
        time, values = draft.series(one.table, one.column)
        time = np.arange(time.size) if (np.diff(time) < 0.0).any() else time
        kept = envelope(values, DRAWN)
        found.append({"table": one.table, "column": one.column, "time": numbers(time[kept]),
                      "values": numbers(values[kept])})  # fmt: skip
    return found


def _stored(records: Sequence[Record], out: Path) -> dict[str, Any]:
    """Write the records and their drawings; names, times and the proposed parts."""
    from .. import write_record
    from ..reporting.open.views import record_view
    from .parts import copies, lacks, proposed

    told: list[dict[str, Any]] = []
    again = copies(records)
    for number, record in enumerate(records):
        write_record(record, out / f"{number}.parquet")
        Path(out, f"{number}.json").write_text(json.dumps(record_view(record)), "utf-8")
        told.append({"name": record.name, "samples": record.n, "from": float(record.time_s[0]),
                     "to": float(record.time_s[-1]), "channels": list(record.channels),
                     "positive_rudder": record.meta.positive_rudder, "lacks": lacks(record),
                     "again": again.get(number, "")})  # fmt: skip
    return {"records": told, "parts": proposed(records, again)}


# ------------------------------------------------------------------------------------------------ analyses


def analyse(recipe: Recipe, model: str, records: Sequence[str], out: str, stage: Stage) -> dict[str, Any]:
    """Check, identify or diagnose, and write all files of it into `out`.

    recipe : what is asked of what.  model : its model, a path where that is a file.  records : paths of the records.

    Returns
    -------
    What lists of results show.
    """
    from ..models.result import page_of
    from ..reporting.open.views import view_of
    from . import recipes

    stage("cutting the records")
    cut = [(part, cut_part(records[int(part["record"])], part)) for part in recipe.parts]
    train = [record for part, record in cut if part["role"] == "train"]
    held_out = [record for part, record in cut if part["role"] == "held_out"]
    if not train:
        raise BadInput("no part is for training", hint="mark one at least")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = RUNS[recipe.kind](train, held_out, model, recipe.method, stage)
    stage("drawing the result")
    folder = Path(out)
    found.write(folder)
    view = view_of(page_of(found))
    _write_parts(folder / RECORDS, cut)
    view = view | {"kind": recipe.kind, "told": [*view["told"], *dict.fromkeys(_doubts(told))]}
    (folder / VIEW).write_text(json.dumps(plain(view), allow_nan=False), "utf-8")
    recipes.write(folder, recipe)
    return {name: view[name] for name in ("kind", "tone", "label", "sentence")} | {"model": recipe.model}


def cut_part(path: str, part: Mapping[str, Any]) -> Record:
    """A part of a record under its own name."""
    from .. import read_record

    return replace(read_record(path).between(part["from"], part["to"]), name=part["name"])


def _doubts(told: Sequence[warnings.WarningMessage]) -> list[str]:
    from .. import PlausibilityWarning, RudderSignWarning

    return [str(one.message) for one in told if issubclass(one.category, PlausibilityWarning | RudderSignWarning)]


def _write_parts(folder: Path, cut: Sequence[tuple[Mapping[str, Any], Record]]) -> None:
    from .. import write_record

    folder.mkdir()
    for _, record in cut:
        write_record(record, folder / f"{record.name}.csv")


def _checked(train: list[Record], held_out: list[Record], model: str, method: str, stage: Stage) -> Any:
    from .. import check

    stage("comparing the channels with each other")
    return check([*train, *held_out])


def _identified(train: list[Record], held_out: list[Record], model: str, method: str, stage: Stage) -> Any:
    from .. import identify

    stage("fitting the models that the records allow" if model == "auto" else "fitting the model")
    estimate = identify(train, model, method, validate=held_out)
    stage("judging the fit: free runs, residuals, what the records tell")
    return estimate.assess()


def _diagnosed(train: list[Record], held_out: list[Record], model: str, method: str, stage: Stage) -> Any:
    from .. import build_model, diagnose

    if model == NO_MODEL:
        return build_model(train, held_out, progress=stage)
    return diagnose(model, train, held_out, progress=stage)


RUNS = {"check": _checked, "identify": _identified, "diagnose": _diagnosed}
TASKS: dict[str, Callable[..., Any]] = {"read": read_logs, "analyse": analyse}
