"""The page of a craft's diagnosis as Markdown, for publishing: statistics only, no series."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .. import tables
from ..report import sentences
from ..validation.tables import horizon_table, trusted_lines
from . import text as words

if TYPE_CHECKING:
    from ...diagnosis.craft.result import CraftDiagnosis


def write_markdown(found: CraftDiagnosis, folder: Path, name: str, title: str, note: str) -> None:
    """Write `name`.md into a folder that exists."""
    from ...models.folders import write_atomic

    write_atomic(folder / f"{name}.md", markdown(found, title, note).encode())


def markdown(found: CraftDiagnosis, title: str, note: str) -> str:
    """The Markdown text."""
    story = words.statement(found)
    records = ", ".join(f"{tables.in_markdown(name)} ({role.replace('_', ' ')})" for name, role in found.records)
    parts = [f"# {title}", note, f"**{words.headline(found)}.** {story[0]}", sentences(story[1:])]
    parts += ["## What steers it", tables.markdown(words.laws_table(found))]
    parts += ["## The ladder", tables.markdown(words.steps_table(found))]
    parts += ["## The model", tables.markdown(words.numbers_table(found))]
    parts += ["## How far ahead", f"{found.ahead.horizon_basis}.", "R²:", tables.markdown(words.r2_table(found))]
    parts += ["Root mean square errors:", tables.markdown(horizon_table(found.ahead))]
    parts += [sentences(f"{line}." for line in trusted_lines(found.ahead))]
    parts += ["## Heading", tables.markdown(words.band_table(found)), tables.markdown(words.angles_table(found))]
    parts += ["## Made with", f"Family {found.model.family}; records {records}."]
    return "\n\n".join(part for part in parts if part) + "\n"
