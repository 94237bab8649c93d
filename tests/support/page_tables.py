"""Tables of a page as a reader sees them."""

import re
from html import unescape


def page_tables(page: str) -> list[list[list[str]]]:
    """Every table of a page: a list of rows of texts, titles first (they are buttons that sort)."""
    shown = re.sub(r"</?button.*?>", "", page)
    out = []
    for table in re.findall(r"<table>(.*?)</table>", shown, re.DOTALL):
        rows = re.findall(r"<tr.*?>(.*?)</tr>", table, re.DOTALL)
        out.append([[unescape(c) for c in re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row, re.DOTALL)] for row in rows])
    return out
