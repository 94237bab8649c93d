"""Diagnose a model with a user's own records: what `helmbench diagnose` calls."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .models.errors import BadInput
from .models.model import CHANNELS, model_to_json, resolve

if TYPE_CHECKING:
    from .diagnosis.options import Options
    from .diagnosis.result import Diagnosis

FILES = ("diagnosis.json", "diagnosis.html", "extended_model.json")
SHORT_CHANNELS = {"heading": "psi", "yaw_rate": "r", "surge": "u", "sway": "v", "north": "x", "east": "y"}
"""Names that `--channels` takes -> states."""


def diagnose_files(
    model: str,
    train: Sequence[str | Path],
    held_out: Sequence[str | Path],
    options: Options,
    positive_rudder: str | None = None,
) -> Diagnosis:
    """Read the records and diagnose the model.

    Raises
    ------
    BadInput : a file or model cannot be used, a file stands on both sides, or the records lack what a diagnosis needs.
    """
    from .datasets.io import read_record
    from .diagnosis.diagnose import diagnose
    from .models.errors import CannotFit

    base = resolve(model)
    _check_sides(train, held_out)
    options.checked(base)
    records = [read_record(path, positive_rudder).turned(base.positive_rudder) for path in train]
    others = [read_record(path, positive_rudder).turned(base.positive_rudder) for path in held_out]
    try:
        found = diagnose(base, records, others, options)
    except CannotFit as reason:
        raise BadInput(f"{model} cannot be diagnosed: {reason}") from None
    return _with_files(found, [*train, *held_out])


def channel_columns(text: str | None) -> tuple[str, ...] | None:
    """`heading,yaw_rate` or `heading_rad,...` as the names of record columns; None: all that the records hold."""
    if text is None:
        return None
    columns = {short: CHANNELS[state] for short, state in SHORT_CHANNELS.items()}
    names = [name.strip() for name in text.split(",")]
    known = columns | {column: column for column in columns.values()}
    for name in names:
        if name not in known:
            raise BadInput(f"--channels: unknown channel {name!r}", hint=f"known: {', '.join(columns)}")
    return tuple(dict.fromkeys(known[name] for name in names))


def write_diagnosis(found: Diagnosis, folder: str | Path) -> tuple[Path, ...]:
    """Write diagnosis.json, diagnosis.html and extended_model.json into a folder: all of them or none.

    Raises
    ------
    BadInput : the folder cannot be written to.
    """
    from .bench.store import plain
    from .datasets.files import replace_together
    from .reporting.diagnosis.page import html

    folder = Path(folder)
    document = json.dumps(plain(found.to_json()), indent=1, allow_nan=False) + "\n"
    page = html(found)
    created = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot be made ({error.strerror or error})", file=folder) from None
    paths = [folder / name for name in FILES]
    try:
        replace_together(
            {
                paths[0]: lambda place: place.write_text(document, "utf-8"),
                paths[1]: lambda place: place.write_text(page, "utf-8"),
                paths[2]: lambda place: model_to_json(replace(found.extended, id="extended_model"), place),
            }
        )
    except BaseException:
        if created:
            folder.rmdir()
        raise
    return tuple(paths)


def check_target(folder: Path) -> None:
    """Refuse an output folder that cannot be made, before anything is computed."""
    if folder.exists() and not folder.is_dir():
        raise BadInput("is a file", file=folder, hint="give a directory with -o")
    if not folder.exists() and not folder.resolve().parent.is_dir():
        raise BadInput("no such directory", file=folder.parent)


def _check_sides(train: Sequence[str | Path], held_out: Sequence[str | Path]) -> None:
    both = {Path(path).resolve() for path in train} & {Path(path).resolve() for path in held_out}
    if both:
        hint = "a held-out record takes no part in training"
        raise BadInput("stands under --train and --held-out", file=sorted(both)[0], hint=hint)


def _with_files(found: Diagnosis, paths: Sequence[str | Path]) -> Diagnosis:
    """The diagnosis with the files as the user named them in the place of the records' names."""
    roles = [role for _, role in found.records]
    return replace(found, records=tuple((str(path), role) for path, role in zip(paths, roles, strict=True)))
