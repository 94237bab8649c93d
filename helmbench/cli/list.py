"""`helmbench list KIND`."""

from __future__ import annotations

import click

from ._shared import print_json

KINDS = ("models", "vessels", "manoeuvres", "methods", "causes", "diagnosers", "suites")


@click.command("list")
@click.argument("kind", type=click.Choice(KINDS), metavar="|".join(KINDS))
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def list_command(kind: str, as_json: bool) -> None:
    """List what there is: identifier and title."""
    from ..api import lists
    from ..api.documents import titles_text

    found: dict[str, str] = getattr(lists, f"list_{kind}")()
    if as_json:
        print_json([{"id": name, "title": title} for name, title in found.items()])
        return
    click.echo(titles_text(found))
