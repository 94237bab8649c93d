"""Commands on this installation: doctor, completion, open."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from ._from_api import command
from ._shared import FAILED, FILE, OK, Printer, echo

# ---- `helmbench doctor`.


@command()
def doctor(printer: Printer) -> int:
    """Look at what helmbench needs on this machine.

    Packages, compiled code, data, threads, disk, permissions: each line is ok, a warning or a fault, with what to do.
    Exit status 1 where there is a fault.
    """
    import helmbench

    found = helmbench.doctor()
    printer.show(found.to_json, found.summary)
    faults = [one for one in found.findings if one.status == "fault"]
    if faults and printer.quiet and not printer.as_json:
        echo("\n".join(f"{one.what}: {one.told}; {one.todo}" for one in faults), err=True)
    return FAILED if found.status == "fault" else OK


# ---- `helmbench completion SHELL`.

SHELLS = ("bash", "zsh", "fish")


@click.command()
@click.argument("shell", type=click.Choice(SHELLS), metavar="|".join(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script with which a shell completes words.

    Commands, options, and identifiers of methods, vessels, suites and causes.

    \b
    bash:  helmbench completion bash > ~/.local/share/bash-completion/completions/helmbench
    zsh:   helmbench completion zsh > a file _helmbench in a folder of $fpath
    fish:  helmbench completion fish > ~/.config/fish/completions/helmbench.fish
    """
    made = get_completion_class(shell)
    assert made is not None, "click completes in each of SHELLS"
    click.echo(made(context.find_root().command, {}, "helmbench", "_HELMBENCH_COMPLETE").source())


# ---- `helmbench open [FILE...]`.


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
