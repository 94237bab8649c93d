"""`helmbench list KIND`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import click

from ._shared import echo, print_json

if TYPE_CHECKING:
    from ..methods.options import Option

KINDS = ("models", "vessels", "manoeuvres", "methods", "causes", "diagnosers", "suites")


@click.command("list")
@click.argument("kind", type=click.Choice(KINDS), metavar="|".join(KINDS))
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def list_command(kind: str, name: str | None, as_json: bool) -> None:
    """List what there is: models, vessels, methods, causes, suites.

    `list methods NAME` lists the options of a method.
    """
    from .. import BadInput, method_options
    from ..api import lists

    if name is not None:
        if kind != "methods":
            raise BadInput(f"list {kind} takes no name", hint="'list methods NAME' lists the options of a method")
        options = method_options(name)
        if as_json:
            print_json([option.texts() for option in options])
        else:
            echo(_options_text(options))
        return

    found: dict[str, str] = getattr(lists, f"list_{kind}")()
    if as_json:
        print_json([{"id": name, "title": title} for name, title in found.items()])
        return
    echo(_titles_text(found))


def _titles_text(titles: Mapping[str, str]) -> str:
    """Identifiers and their titles in two columns."""
    from ..reporting.tables import Cell, Table, console

    return console(Table(("", ""), tuple((Cell(name), Cell(title)) for name, title in titles.items())))


def _options_text(options: Sequence[Option]) -> str:
    """Options of a method with default, meaning, allowed values and searched range, a block each."""
    lines: list[str] = []
    for option in options:
        lines.append(f"{option.name}={option.default}")
        lines += [f"    {option.meaning}"] if option.meaning else []
        lines += [f"    allowed: {option.range}"] if option.range else []
        lines += [f"    tuning searches {option.searched}"] if option.searched else []
    return "\n".join(lines) or "no options"
