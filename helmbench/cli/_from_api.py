"""Options of a command as the signature and the docstring of a function of the API have them, so that each is written
once: name, default and help.  The command adds what a shell needs: the type, and a flag of its own.

Click stays, with this reader of signatures, since options that take several words (`--train a.csv b.csv`), texts of
numbers and identifiers with completion are types of ours, which cyclopts and typer would have to be taught anew.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import click

from ._shared import FILE, SIDES, spread

Settings = Mapping[str, Any]
"""Parameter of the function -> type of the option, or settings of `click.Option` with `flag`: `-o --output`."""
ENTRY = re.compile(r"^(\w+(?:, \w+)*) : (.*(?:\n    .*)*)", re.MULTILINE)
UNITS = re.compile(r"_(s|m_s|gib|deg|rps)$")


class ApiCommand(click.Command):
    """A command with options of a function of the API; the function is loaded when the options are asked for.

    api : public name of the function.  options : its parameters that are options.  greedy : options that take every
    value up to the next option (`--validate a.csv b.csv`).  common : names of the options of every day, with which the
    help begins; empty: all are.
    """

    def __init__(
        self,
        *args: Any,
        api: str,
        options: Settings,
        greedy: Sequence[str] = (),
        common: Sequence[str] = (),
        **settings: Any,
    ) -> None:
        super().__init__(*args, **settings)
        self._api, self._settings, self._greedy, self._common = api, options, greedy, common

    @cached_property
    def _options(self) -> list[click.Option]:
        return options_of(self._api, self._settings)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        own = super().get_params(ctx)
        place = sum(one.required or isinstance(one, click.Argument) for one in own)
        return [*own[:place], *self._options, *own[place:]]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, spread(args, self._greedy))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the common options, then the others below a heading of their own."""
        if not self._common:
            super().format_options(ctx, formatter)
            return
        rows = {option.name: row for option in self.get_params(ctx) if (row := option.get_help_record(ctx))}
        parts = {"Options": self._common, "Further options": [name for name in rows if name not in self._common]}
        for heading, names in parts.items():
            with formatter.section(heading):
                formatter.write_dl([rows[name] for name in names])


def several(kind: click.ParamType[Any], flag: str = "", metavar: str | None = None) -> dict[str, Any]:
    """Settings of an option that is given several times."""
    return {"type": kind, "flag": flag, "multiple": True, "metavar": metavar}


RECORDS = several(FILE, metavar="RECORD...")
TWO_SETS: Settings = {"train": RECORDS, "held_out": RECORDS, "positive_rudder": SIDES}
GREEDY_SETS = ("--train", "--held-out")
EVERY_DAY = ("model", "train", "held_out", "positive_rudder", "output")
"""Names of the options of every day, of a command with training and held-out records."""


def options_of(api: str, settings: Settings) -> list[click.Option]:
    """The options of a public function."""
    import helmbench

    function = getattr(helmbench, api)
    parameters, helps = inspect.signature(function).parameters, helps_of(function)
    return [_option(parameters[name], helps[name], own) for name, own in settings.items()]


def helps_of(function: Any) -> dict[str, str]:
    """Parameter -> what the section `Parameters` of a docstring says of it."""
    section = (inspect.getdoc(function) or "").partition("Parameters\n----------\n")[2]
    entries = ENTRY.findall(re.split(r"^\w+\n-+\n", section, flags=re.MULTILINE)[0])
    return {name: " ".join(text.split()) for names, text in entries for name in names.split(", ")}


def _option(parameter: inspect.Parameter, text: str, own: Any) -> click.Option:
    settings = dict(own) if isinstance(own, Mapping) else {"type": own}
    flags = (settings.pop("flag", "") or f"--{UNITS.sub('', parameter.name).replace('_', '-')}").split()
    names, told = [*flags, parameter.name], _sentence(text)
    if parameter.default is inspect.Parameter.empty:
        return click.Option(names, required=True, help=told, **settings)
    if parameter.default is False:
        return click.Option(names, is_flag=True, help=told)
    if settings.get("multiple") and parameter.default is None:
        settings["callback"] = lambda ctx, param, values: values or None
    shown = isinstance(parameter.default, str | int | float)
    return click.Option(names, default=parameter.default, show_default=shown, help=told, **settings)


def _sentence(text: str) -> str:
    """The help with a capital, and with what stands for None as the default."""
    text, _, default = text.replace("`", "").rstrip(".").partition("; None: ")
    return f"{text[:1].upper()}{text[1:]}.{f'  [default: {default}]' if default else ''}"
