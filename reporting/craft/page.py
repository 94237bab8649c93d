"""The page of a craft's diagnosis: what steers it, the ladder, errors ahead, the heading band, charts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..templating import render
from ..validation.page import key_of, panels
from ..validation.tables import horizon_table, trusted_lines
from . import text as words

if TYPE_CHECKING:
    from ...diagnosis.craft.result import CraftDiagnosis


def html(found: CraftDiagnosis) -> str:
    """The page, self-contained."""
    return render(
        "craft.html.j2",
        found=found,
        headline=words.headline(found),
        statement=words.statement(found),
        laws=words.laws_table(found),
        steps=words.steps_table(found),
        numbers=words.numbers_table(found),
        shares=words.r2_table(found),
        horizons=horizon_table(found.ahead),
        trusted=trusted_lines(found.ahead),
        band=words.band_table(found),
        angles=words.angles_table(found),
        panels=panels(found.ahead),
        key=key_of(found.ahead),
    )
