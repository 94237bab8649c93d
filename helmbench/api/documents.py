"""Results as text: JSON for machines, tables for the terminal."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..estimation.estimate import Estimate


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    from ..bench.store import plain

    return json.dumps(plain(value), indent=1, allow_nan=False)


def titles_text(titles: Mapping[str, str]) -> str:
    """Identifiers and their titles in two columns."""
    from ..reporting.tables import Cell, Table, console

    return console(Table(("", ""), tuple((Cell(name), Cell(title)) for name, title in titles.items())))


def parameters_text(estimate: Estimate) -> str:
    """The parameters of an estimate with their standard errors, as a table."""
    from ..reporting.identification import parameter_table
    from ..reporting.tables import console

    return console(parameter_table(estimate), indent="  ")


def scores_text(scores: Mapping[str, Any]) -> str:
    """Errors of free runs and of one-step predictions by channel, as a table."""
    from ..reporting.identification import score_table
    from ..reporting.tables import console

    return console(score_table(scores), indent="  ")
