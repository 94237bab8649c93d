"""Options of commands are those of the API: each parameter that a command takes has its type, default and help."""

from __future__ import annotations

import click
import pytest

from helmbench.cli import cli
from helmbench.cli._from_api import helps_of, options_of, several
from helmbench.cli._shared import WholeRange


def documented(first: str, count: int = 3, names: object = None, quick: bool = False) -> None:
    """A function.

    Parameters
    ----------
    first : what stands
        on two lines; None: `nothing`.
    count, quick : 'both' of them.
    names : several.

    Raises
    ------
    BadInput : never.
    """


def test_the_section_of_parameters_is_read():
    assert helps_of(documented) == {
        "first": "what stands on two lines; None: `nothing`.", "count": "'both' of them.",
        "quick": "'both' of them.", "names": "several.",
    }  # fmt: skip


def test_an_option_has_default_flag_and_help_of_its_parameter(monkeypatch):
    monkeypatch.setattr("helmbench.documented", documented, raising=False)
    own = {"names": several(click.STRING, "-n --name")}
    first, count, names, quick = options_of("documented", ["first", "count", "names", "quick"], own)
    assert first.required and first.help == "What stands on two lines.  [default: nothing]"
    assert (
        isinstance(count.type, WholeRange)
        and first.type is click.STRING
        and count.default == 3
        and count.help == "'both' of them."
        and count.opts == ["--count"]
    )
    assert names.opts == ["-n", "--name"] and names.multiple and quick.is_flag
    command = click.Command("one", params=[first, count, names, quick], callback=lambda **given: given)
    assert command.main(["--first", "a"], standalone_mode=False) == {
        "first": "a", "count": 3, "names": None, "quick": False,
    }  # fmt: skip


COMMANDS = [
    *cli.commands.values(),
    *(own for c in cli.commands.values() for own in getattr(c, "commands", {}).values()),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda one: one.name)
def test_every_option_of_the_api_says_what_it_does(command):
    for option in command.get_params(click.Context(command, **cli.context_settings)):
        assert isinstance(option, click.Argument) or len(option.help) > 10
