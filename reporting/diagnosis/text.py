"""A diagnosis as text, in the terminal and in a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from ..numbers import p_value
from ..tables import console, html
from ..validation.tables import trusted_lines
from .tables import gain_table
from .words import headline, remaining, said, sentence, separation, size, tie, verdict

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis


def terminal(found: Diagnosis) -> str:
    """The verdict, the causes with their sizes, and the gain, in plain text."""
    lines = [f"doubtful: {doubt}" for doubt in found.doubts]
    lines += [headline(found), verdict(found), *([sentence(found.reason)] if found.reason else [])]
    for finding in found.causes:
        lines.append(f"  {tie(finding)}  (stage {finding.stage}, adjusted p {p_value(finding.p_adjusted)})")
        lines += [f"    {size(item)}" for item in finding.sizes]
        lines += [f"    {text}" for text in (said(finding.evidence), separation(finding)) if text]
    lines += [f"  {remaining(force)}" for force in found.remaining]
    if found.gain:
        lines.append(console(gain_table(found), indent="  "))
    elif not any(role == "held_out" for _, role in found.records):
        lines.append("no held-out records: the gain was not measured")
    lines += [] if found.ahead is None else trusted_lines(found.ahead)
    lines += [f"next manoeuvre: {found.next_manoeuvre}"] if found.next_manoeuvre else []
    return "\n".join(lines)


def notebook(found: Diagnosis) -> str:
    """Verdict, causes with their sizes, and gain as HTML."""
    told = [*(f"doubtful: {doubt}" for doubt in found.doubts), sentence(found.reason)]
    told += [f"Recommended next manoeuvre: {found.next_manoeuvre}"] if found.next_manoeuvre else []
    causes = [": ".join(filter(None, (tie(f), "; ".join(map(size, f.sizes)), said(f.evidence)))) for f in found.causes]
    causes += map(remaining, found.remaining)
    head = f"<p><b>{escape(headline(found))}</b> {escape(verdict(found))}</p>"
    texts = "".join(f"<p>{escape(text)}</p>" for text in told if text)
    listed = "".join(f"<li>{escape(text)}</li>" for text in causes)
    return f"{head}{texts}<ul>{listed}</ul>{html(gain_table(found)) if found.gain else ''}"
