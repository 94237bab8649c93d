"""`helmbench open [FILE...]`."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from ._shared import FILE, echo


@click.command("open")
@click.argument("files", nargs=-1, metavar="[FILE]...", type=FILE)
@click.option("--no-browser", is_flag=True, help="Only print the link; open it yourself.")
def open_command(files: tuple[Path, ...], no_browser: bool) -> None:
    """Open a page in the browser on which a log becomes an answer.

    Drop logs, look at every column, cut parts; then check, identify or diagnose.

    The server answers to this machine only, and logs do not leave it.  It runs until Ctrl-C; all that was dropped is
    deleted then, so download what you want to keep.
    """
    from ..open.serve import serve

    def say(link: str) -> None:
        echo(f"{link}\nThis link opens helmbench once; press Enter for another. Logs stay on this machine.")
        echo("Ctrl-C ends it and deletes what was dropped.")

    with suppress(KeyboardInterrupt):  # the way in which it ends
        serve(files, say, not no_browser)
