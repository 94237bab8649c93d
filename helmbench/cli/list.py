"""`helmbench list KIND`."""

from __future__ import annotations

import click

from ._shared import echo, print_json

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
    from ..api.documents import options_text, titles_text

    if name is not None:
        if kind != "methods":
            raise BadInput(f"list {kind} takes no name", hint="'list methods NAME' lists the options of a method")
        options = method_options(name)
        if as_json:
            print_json([option.texts() for option in options])
        else:
            echo(options_text(options))
        return

    found: dict[str, str] = getattr(lists, f"list_{kind}")()
    if as_json:
        print_json([{"id": name, "title": title} for name, title in found.items()])
        return
    echo(titles_text(found))
