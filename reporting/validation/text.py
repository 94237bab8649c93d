"""A validation for the terminal and for notebooks."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from ..tables import console, html
from .tables import free_table, horizon_table, index_table, left_out_table, trusted_lines

if TYPE_CHECKING:
    from ...estimation.validation.result import Validation


def terminal(found: Validation) -> str:
    """Errors of free runs and ahead, indices, and what was left out."""
    parts = [f"doubtful: {doubt}" for doubt in found.doubts]
    parts += [f"free runs of {', '.join(found.models)} along {count(found)}", console(free_table(found), "  ")]
    parts += [f"{run.model} along {run.record}: {run.told}" for run in found.runs if run.told]
    parts += [f"root mean square errors ahead; {found.horizon_basis}", console(horizon_table(found), "  ")]
    parts += trusted_lines(found)
    if found.indices:
        parts += ["manoeuvring indices (IMO MSC.137(76))", console(index_table(found), "  ")]
    if found.left_out:
        parts += ["left out", console(left_out_table(found), "  ")]
    return "\n".join(parts)


def notebook(found: Validation) -> str:
    """Errors of free runs and indices as HTML."""
    told = [*(f"doubtful: {doubt}" for doubt in found.doubts), f"free runs along {count(found)}"]
    told += [f"{run.model} along {run.record}: {run.told}" for run in found.runs if run.told]
    indices = f"<p>manoeuvring indices</p>{html(index_table(found))}" if found.indices else ""
    return "".join(f"<p>{escape(text)}</p>" for text in told) + html(free_table(found)) + indices


def count(found: Validation) -> str:
    """`3 records`, or the name of the only one."""
    names = [record.name for record in found.records]
    return names[0] if len(names) == 1 else f"{len(names)} records"
