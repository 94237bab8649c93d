"""`helmbench completion SHELL`."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

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
