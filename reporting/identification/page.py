"""The page of an identification: verdict, free runs, residuals, parameters, what the records tell, advice."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..templating import render
from ..validation.page import key_of, panels
from ..validation.tables import free_table, horizon_table, left_out_table, trusted_lines
from ..validation.text import count
from . import text as words
from .charts import SIDES, residual_charts
from .tables import assessed_table, comparison_note, comparison_table, next_table, residual_table, told_table

if TYPE_CHECKING:
    from ...estimation.judgement.assessment import Assessment


def html(found: Assessment) -> str:
    """The page, self-contained."""
    sides = [("Held-out records", found.held_out)] if found.held_out is not None else []
    sides.append(("Training records", found.train))
    shown = [
        {"title": title, "records": count(part), "free": free_table(part), "panels": panels(part),
         "left_out": left_out_table(part)}
        for title, part in sides
    ]  # fmt: skip
    told = found.identifiability
    return render(
        "identification.html.j2",
        found=found,
        headline=words.headline(found),
        statement=words.statement(found),
        sides=shown,
        horizons=horizon_table(found.judged),
        horizon_basis=found.judged.horizon_basis,
        trusted=trusted_lines(found.judged),
        key=key_of(found.train),
        residuals=residual_table(found),
        charts=residual_charts(found),
        residual_key=[(side, colour) for side, colour in SIDES.items() if side == "training" or found.held_out],
        parameters=assessed_table(found),
        told=told_table(found),
        groups=() if told is None else told.group_lines(),
        noise={} if told is None else told.noise_sd,
        next=next_table(found),
        comparison=None if found.comparison is None else comparison_table(found.comparison),
        comparison_note="" if found.comparison is None else comparison_note(found.comparison),
        compared=() if found.compared is None else panels(found.compared),
        compared_key=() if found.compared is None else key_of(found.compared),
    )
