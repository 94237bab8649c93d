"""Pages as PDF, by WeasyPrint (extra `pdf`)."""

from __future__ import annotations

import logging

from ..models.errors import BadInput
from ..models.extras import extras_told


def pdf(page: str) -> bytes:
    """A self-contained page (HTML) as a PDF file, as it would be printed; nothing is loaded.

    Raises
    ------
    BadInput : WeasyPrint or the libraries of Pango that it draws text with are not installed.
    """
    with extras_told():
        try:
            from weasyprint import HTML
        except OSError:
            raise BadInput(
                "WeasyPrint finds no Pango", hint="apt-get install libpangoft2-1.0-0, or write HTML"
            ) from None
    logging.getLogger("weasyprint").setLevel(logging.ERROR)  # it warns of rules for screens, which it does not apply
    return bytes(HTML(string=page, url_fetcher=_refused).write_pdf() or b"")


def _refused(url: str) -> dict[str, object]:
    raise ValueError(f"a page loads nothing, not {url}")
