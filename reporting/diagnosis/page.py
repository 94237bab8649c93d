"""What a diagnosis says: the verdict, causes with sizes, what remains, what to sail next, what was tested."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..numbers import p_value, percent
from ..page import (
    BAD,
    FAIR,
    GOOD,
    Block,
    Pairs,
    Section,
    Verdict,
    equation_parts,
    items,
    overlays,
    result_page,
    sides,
)
from ..runs import of_trace
from ..validation.tables import horizon_table, trusted_lines
from . import words
from .figures import error_drawings, force_drawings
from .tables import bank_table, error_table, gain_table, instrument_rows, not_testable_table, where_table

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Finding
    from ..page import Page

TONES = {"adequate": GOOD, "unexplained": BAD}
"""Verdict -> how it is set off; others are fair."""


def page(found: Diagnosis) -> Page:
    """The page of a diagnosis."""
    overview, each = overlays([of_trace(trace, found.extends) for trace in found.traces])
    return result_page(
        f"Diagnosis of {found.model.id}",
        f"{found.model.title or found.model.family}; {sides(found.records)}",
        Verdict(TONES.get(found.verdict, FAIR), words.headline(found), _told(found)),
        seen=[overview, *_gain(found)],
        changed=_changed(found),
        remains=_remains(found),
        following=_following(found),
        details=[
            *_equations(found),
            Section("The causes that were tested", (bank_table(found),)),
            Section("Causes that cannot be tested with this model and these records", (not_testable_table(found),)),
            Section("Where the errors of the base model arise", (where_table(found),)),
            Section("Errors of every record", (error_table(found), *error_drawings(found))),
            *_ahead(found),
            each,
            Section("Made with", (Pairs(tuple(words.facts(found))),)),
        ],
        doubts=found.doubts,
    )


def _told(found: Diagnosis) -> tuple[str, ...]:
    return tuple(filter(None, (words.verdict(found), words.sentence(found.reason))))


def _gain(found: Diagnosis) -> list[Block]:
    if found.gain:
        return [gain_table(found)]
    tested = any(role == "held_out" for _, role in found.records)
    return ["No gain was measured." if tested else "There were no held-out records: the gain was not measured."]


def _changed(found: Diagnosis) -> list[Block]:
    """Causes with sizes, and the new terms of the equations with their numbers."""
    if not found.extends:
        return ["The model stays as it is."]
    causes = items([_finding(found, finding) for finding in found.causes])
    return [causes, equation_parts(found.extended, found.model)[0], Pairs(tuple(instrument_rows(found)))]


def _finding(found: Diagnosis, finding: Finding) -> tuple[str, ...]:
    sizes = "; ".join(words.size_and_change(found.model, finding, item) for item in finding.sizes)
    details = "; ".join(f"{name}: {words.detail(value)}" for name, value in finding.details.items())
    texts = (
        f"{sizes} ({percent(finding.level)} interval)" if sizes else "",
        words.sentence(finding.evidence),
        details,
        f"Stage {finding.stage}, adjusted p {p_value(finding.p_adjusted)}.",
    )
    return (words.tie(finding), *filter(None, texts))


def _remains(found: Diagnosis) -> list[Block]:
    """Forces that no cause explains with their curves, the hypothesis about what is unexplained, and how far ahead the
    model can be trusted."""
    trusted = [] if found.ahead is None else [f"{line}." for line in trusted_lines(found.ahead)]
    hint = "None of the known causes: the sparse term that fits best. Use it as a hint only."
    hypothesis = [hint, Pairs(tuple(words.hypothesis(found)))] if found.hypothesis else []
    forces = items([words.remaining(force) for force in found.remaining])
    return [forces, *force_drawings(found), *hypothesis, items(trusted)]


def _following(found: Diagnosis) -> list[Block]:
    """The recommended manoeuvre, and what would tell tied causes apart."""
    said = [found.next_manoeuvre] if found.next_manoeuvre else []
    separations = [words.separation(finding) for finding in found.causes]
    return [items([words.sentence(text) for text in (*said, *separations) if text])]


def _equations(found: Diagnosis) -> list[Section]:
    return [equation_parts(found.extended, found.model)[1]] if found.extends else []


def _ahead(found: Diagnosis) -> list[Section]:
    """Errors some time ahead beside predictions without a model; nothing where none were computed."""
    if found.ahead is None:
        return []
    note = "Behind the models stand two predictions without one, and the noise of the sensors, which no model can beat."
    basis = f"Root mean square errors ahead; {found.ahead.horizon_basis}."
    return [Section("How far ahead", (basis, horizon_table(found.ahead), note))]
