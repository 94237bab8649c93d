"""The report of a run directory, by the kind of its suite."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ..bench.kinds import DIAGNOSIS, IDENTIFICATION
from ..bench.store import read_manifest

if TYPE_CHECKING:
    from .leaderboard.page import Report

PAGES = {IDENTIFICATION: ".leaderboard.page", DIAGNOSIS: ".diagnosis_suite.page"}
"""Kind of suite -> the module that writes its report."""


def write_report(directory: str | Path, timing: str | Path | None = None) -> Report:
    """Report a run directory by the kind of its suite; raises what the report of that kind does."""
    kind = read_manifest(Path(directory)).get("kind", IDENTIFICATION)
    return import_module(PAGES[kind], __package__).write_report(directory, timing)
