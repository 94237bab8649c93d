"""Completion in the shell: commands, options and identifiers, as click computes them."""

import pytest
from click.shell_completion import ShellComplete

import helmbench
from helmbench.cli import cli, status_of


def completed(*words):
    """What the shell offers for the last word of a command line."""
    *before, last = words
    found = ShellComplete(cli, {}, "helmbench", "_HELMBENCH_COMPLETE").get_completions(before, last)
    return {item.value: item for item in found}


@pytest.mark.parametrize(
    ("words", "ids"),
    [
        (("identify", "--method", "out"), {"output-error"}),
        (("identify", "--compare", "fw"), {"fw-rls"}),
        (("identify", "--model", "au"), {"auto"}),
        (("identify", "--model", "kvlcc2"), {"kvlcc2-l7"}),
        (("simulate", "response"), {"response-1", "response-2"}),
        (("validate", "mariner-"), {"mariner-model"}),
        (("calibrate", "--model", "remus-"), {"remus-kt"}),
        (("run", "--suite", "qu"), {"quick"}),
        (("run", "--vessel", "patr"), {"patrol"}),
        (("diagnose", "--causes", "rudder_o"), {"rudder_offset"}),
        (("list", "cau"), {"causes"}),
        (("diag",), {"diagnose"}),
    ],
)
def test_identifiers_are_completed(words, ids):
    assert set(completed(*words)) == ids


def test_titles_stand_beside_them_and_files_are_offered_otherwise():
    assert completed("run", "--suite", "qu")["quick"].help == helmbench.list_suites()["quick"]
    (item,) = completed("identify", "--model", "out/mine").values()
    assert item.type == "file"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_calls_the_program(shell, capsys):
    assert status_of(["completion", shell]) == 0
    assert "_HELMBENCH_COMPLETE" in capsys.readouterr().out


def test_every_command_prints_json():
    parts = [getattr(command, "commands", {name: command}) for name, command in cli.commands.items()]
    without = {name for own in parts for name, command in own.items()
               if "--json" not in {option for parameter in command.params for option in parameter.opts}}  # fmt: skip
    assert without == {"completion", "open"}
