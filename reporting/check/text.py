"""A check for the terminal and for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import tables
from .tables import brief, findings, name

if TYPE_CHECKING:
    from ...checks.result import CheckResult

NOTHING = "no findings: the channels agree with each other, and the samples show no fault"


def headline(found: CheckResult) -> str:
    """How many findings there are, in one line."""
    n, m = len(found.records), sum(f.material for f in found.findings)
    rest = len(found.findings) - m
    told = f"{m} finding{'s' if m != 1 else ''}" if m else "nothing that matters"
    small = f", {rest} detectable but too small to matter" if rest else ""
    return f"{n} record{'s' if n != 1 else ''}: {told}{small}"


def terminal(found: CheckResult) -> str:
    """Table, evidence of each finding, and what could not be checked."""
    parts = [headline(found)]
    if found.findings:
        parts += ["", tables.console(brief(found))]
        parts += ["", *(f"{name(f)}: {f.evidence}" for f in found.findings if f.material)]
    else:
        parts += [NOTHING]
    if found.not_checked:
        parts += ["", "not checked:", *(f"  {why}" for why in found.not_checked)]
    return "\n".join(parts)


def notebook(found: CheckResult) -> str:
    """The findings as an HTML table."""
    from html import escape

    return f"<p>{escape(headline(found))}</p>" + (tables.html(findings(found)) if found.findings else "")
