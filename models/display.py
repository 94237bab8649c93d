"""How objects are shown in notebooks: plain HTML tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .model import Model


def html_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A plain HTML table of texts."""
    head = "".join(f"<th>{escape(text)}</th>" for text in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def model_html(model: Model) -> str:
    """A model as a table for notebooks: its published parameters, and where they come from."""
    values = model.to_parameters(model.coefficients)
    pairs = zip(model.parameter_names, values.tolist(), model.parameter_units, strict=True)
    rows = [(name, f"{value:.5g}" if np.isfinite(value) else "", unit) for name, value, unit in pairs]
    facts = [f"family {model.family}", model.source, f"positive rudder to {model.positive_rudder}"]
    facts += [f"{model.speed_m_s:g} m/s"] if np.isfinite(model.speed_m_s) else []
    told = "; ".join(escape(fact) for fact in facts if fact)
    title = f"<p><b>{escape(model.id)}</b>: {escape(model.title)}<br>{told}</p>"
    return title + html_table(("parameter", "value", "unit"), rows)
