"""What a diagnosis says: the verdict, causes with sizes, what remains, what to sail next, what was tested."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...diagnosis.causes.base_coefficients import BaseCoefficients
from ...diagnosis.causes.registry import causes
from ...diagnosis.report.bank import BY_CHANNELS
from ..numbers import number
from ..page import (
    BAD,
    FAIR,
    GOOD,
    Block,
    Drawing,
    Section,
    Verdict,
    equation_parts,
    items,
    overlays,
    pairs,
    result_page,
    sides,
)
from ..plots import SOFT, svg
from ..runs import AFTER, BEFORE, CHANNELS, WIDTH, of_trace, rms
from ..validation.page import explained_lines, horizon_table
from . import words
from .tables import (
    bank_table,
    error_table,
    gain_table,
    instrument_rows,
    not_testable_table,
    numbers_table,
    residual,
    size_table,
    where_table,
)

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Finding, RemainingForce
    from ..page import Page

INSTRUMENTS_OF = "Rudder and sensors of the extended model"
WAVES = "These errors hold the motion in waves, which no simulation has."
TONES = {"adequate": GOOD, "unexplained": BAD}
"""Verdict -> how it is set off; others are fair."""


def page(diagnosis: Diagnosis) -> Page:
    """The page of a diagnosis."""
    overview, each = overlays([of_trace(trace, diagnosis.extends) for trace in diagnosis.traces])
    told = tuple(filter(None, (words.verdict(diagnosis), words.sentence(diagnosis.reason))))
    return result_page(
        f"Diagnosis of {diagnosis.model.id}",
        f"{diagnosis.model.title or diagnosis.model.family}; {sides(diagnosis.records)}",
        Verdict(TONES.get(diagnosis.verdict, FAIR), words.headline(diagnosis), told),
        seen=[overview, *_gain(diagnosis)],
        changed=_changed(diagnosis),
        remains=_remains(diagnosis),
        following=_following(diagnosis),
        details=[
            *([equation_parts(diagnosis.extended, diagnosis.model)[1]] if diagnosis.extends else []),
            *_numbers(diagnosis),
            Section("The causes that were tested", (bank_table(diagnosis),)),
            Section("Causes that cannot be tested with this model and these records", (not_testable_table(diagnosis),)),
            Section("Where the errors of the base model arise", (where_table(diagnosis),)),
            Section("Errors of every record", (error_table(diagnosis), error_drawing(diagnosis))),
            *_ahead(diagnosis),
            each,
            Section("Made with", (pairs(words.facts(diagnosis)),)),
        ],
        doubts=diagnosis.doubts,
    )


def _gain(diagnosis: Diagnosis) -> list[Block]:
    if diagnosis.gain:
        return [gain_table(diagnosis)]
    tested = any(role == "held_out" for _, role in diagnosis.records)
    return ["No gain was measured." if tested else "There were no held-out records: the gain was not measured."]


def _changed(diagnosis: Diagnosis) -> list[Block]:
    """Causes with their sizes, and the new terms of the equations with their numbers."""
    if not diagnosis.extends:
        why = ": what is found is of the records, or of single ones alone" if diagnosis.causes else ""
        return [f"The model stays as it is{why}.", items(list(map(_finding, diagnosis.causes))), size_table(diagnosis)]
    new = [f"{force.text.partition(';')[0]}: a new term" for force in diagnosis.remaining if force.extended]
    instruments = [(INSTRUMENTS_OF, *rows)] if (rows := instrument_rows(diagnosis)) else []
    return [
        items([*map(_finding, diagnosis.causes), *map(words.sentence, new)]),
        size_table(diagnosis),
        equation_parts(diagnosis.extended, diagnosis.model)[0],
        items(instruments),
    ]


def _finding(finding: Finding) -> tuple[str, ...]:
    entry = causes().get(finding.cause)
    told = {name: words.detail(value) for name, value in finding.details.items() if name not in ("numbers", "columns")}
    title = words.tie(finding)
    details = [f"{name}: {text}" for name, text in told.items() if text != title]
    texts = (
        " ".join(entry.physics.split()) if entry is not None and finding.cause != BaseCoefficients.id else "",
        words.sentence(finding.evidence),
        *map(words.sentence, details),
        words.found_by(finding),
    )
    return (title, *filter(None, texts))


def _remains(diagnosis: Diagnosis) -> list[Block]:
    """Forces that no cause explains with their curves, the hypothesis about what is unexplained, and how far ahead the
    model can be trusted."""
    trusted = [] if diagnosis.ahead is None else [f"{line}." for line in explained_lines(diagnosis.ahead)]
    hint = "None of the known causes: the sparse term that fits best. Use it as a hint only."
    hypothesis = [hint, pairs(words.hypothesis(diagnosis))] if diagnosis.hypothesis else []
    if trusted and any(f.stage != BY_CHANNELS for f in words.by_subject(diagnosis)[0]):
        trusted.append(WAVES)
    forces = items([words.remaining(force) for force in diagnosis.remaining])
    return [forces, *force_drawings(diagnosis), *hypothesis, items(trusted)]


def _following(diagnosis: Diagnosis) -> list[Block]:
    """The recommended manoeuvre, and what would tell tied causes apart."""
    following = [words.sentence(diagnosis.next_manoeuvre)] if diagnosis.next_manoeuvre else []
    return [items(words.separations(diagnosis) or following)]


def _numbers(diagnosis: Diagnosis) -> list[Section]:
    """The model's own numbers before and after a joint fit; nothing where none was made."""
    fits = [finding.details["numbers"] for finding in diagnosis.causes if "numbers" in finding.details]
    return [Section("The model's own numbers in their joint fit", (numbers_table(fit),)) for fit in fits]


def _ahead(diagnosis: Diagnosis) -> list[Section]:
    """Errors some time ahead beside predictions without a model; nothing where none were computed."""
    if diagnosis.ahead is None:
        return []
    note = "Behind the models stand two predictions without one, and the noise of the sensors, which no model can beat."
    basis = f"Root mean square errors ahead; {diagnosis.ahead.horizon_basis}."
    return [Section("How far ahead", (basis, horizon_table(diagnosis.ahead), note))]


def error_drawing(diagnosis: Diagnosis) -> Drawing:
    """Errors by record."""
    return Drawing("errors", "Root mean square errors of the free runs", partial(error_bars, diagnosis))


def force_drawings(diagnosis: Diagnosis) -> list[Drawing]:
    """A curve of each force that remains."""
    caption = "The force with its 90 % band, where the records hold data"
    return [
        Drawing(f"remaining-{place}", caption, partial(curve_chart, force))
        for place, force in enumerate(diagnosis.remaining, 1)
        if force.curve is not None
    ]


def error_bars(diagnosis: Diagnosis) -> str:
    """An SVG file of the root mean square errors of the first channel that was measured: a line a record, a bar a run;
    empty where no error is finite."""
    name = next((c for c in CHANNELS if any(c in trace.measured for trace in diagnosis.traces)), None)
    traces = [trace for trace in diagnosis.traces if name in trace.measured]
    runs = ("before", "after")[: 1 + diagnosis.extends]
    word, unit, factor = words.channel(name or "")
    sizes = {run: factor * np.array([rms(residual(trace, str(name), run)) for trace in traces]) for run in runs}
    known = np.concatenate([own[np.isfinite(own)] for own in sizes.values()])
    if not known.size or known.max() <= 0.0:
        return ""
    thick = 0.8 / len(runs)

    def draw(figure) -> None:
        axes = figure.subplots()
        for k, (run, own) in enumerate(sizes.items()):
            places = np.arange(len(traces)) + thick * (k - (len(runs) - 1) / 2.0)
            shown = np.where(np.isfinite(own), own, np.nan)
            drawn = axes.barh(places, shown, thick, color=(BEFORE, AFTER)[k], label=run)
            axes.bar_label(drawn, [number(size) for size in shown], padding=3)
        axes.set_yticks(range(len(traces)), [f"{trace.record} ({trace.role.replace('_', ' ')})" for trace in traces])
        axes.set(
            xlabel=f"RMS error of the {word}, {unit}", ylim=(len(traces) - 0.5, -0.5), xlim=(0.0, 1.12 * known.max())
        )
        axes.grid(visible=False, axis="y")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(runs))

    return svg(draw, (WIDTH, 0.9 + 0.2 * len(traces) * (len(runs) + 1)))


def curve_chart(force: RemainingForce) -> str:
    """An SVG file of a force over the variable that it depends on, in its 90 % band; empty where it has no curve."""
    curve = force.curve
    if curve is None:
        return ""
    unit, factor = ("deg", words.DEG) if curve.variable_unit == "rad" else (curve.variable_unit, 1.0)
    label = curve.variable + (f", {unit}" if unit != "1" else ", U/L")
    x = factor * np.array(curve.values)

    def draw(figure) -> None:
        axes = figure.subplots()
        axes.fill_between(x, curve.low, curve.high, color=AFTER, alpha=0.2, linewidth=0.0)
        axes.plot(x, curve.force, color=AFTER, linewidth=1.5)
        axes.axhline(0.0, color=SOFT, linewidth=0.7)
        axes.set(xlabel=label, ylabel=curve.force_unit, xlim=(x[0], x[-1]))

    return svg(draw, (WIDTH, 2.6))
