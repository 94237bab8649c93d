"""Commands with the options of a function of the API, as its signature and docstring have them, so that each is written
once: name, default, help, and a type by its annotation.  A command adds what a shell needs: another type, a flag of its
own, and where its results go.

Click stays, with this reader of signatures, since options that take several words (`--train a.csv b.csv`), texts of
numbers and identifiers with completion are types of ours, which cyclopts and typer would have to be taught anew.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, wraps
from typing import Any, NamedTuple

import click

from ._shared import (
    CAUSE,
    COMMAS,
    FILE,
    METHOD,
    MODEL,
    NUMBER,
    SIDES,
    SUITE,
    VESSEL,
    NumberRange,
    Printer,
    WholeRange,
    check_file,
    check_folder,
    spread,
)

ENTRY = re.compile(r"^(\w+(?:, \w+)*) : (.*(?:\n    .*)*)", re.MULTILINE)
UNITS = re.compile(r"_(s|m_s|gib|deg|rps)$")
FILES = {"a file": check_file, "a folder": check_folder}
"""What an output is -> what refuses it before anything is computed."""


def several(kind: click.ParamType[Any], flag: str = "", metavar: str | None = None) -> dict[str, Any]:
    """Settings of an option that is given several times."""
    return {"type": kind, "flag": flag, "multiple": True, "metavar": metavar}


RECORDS = several(FILE, metavar="RECORD...")
TYPES: Mapping[str, Any] = {
    **dict.fromkeys(("train", "held_out", "validate"), RECORDS),
    **dict.fromkeys(("table", "jobs", "max_effects"), WholeRange(min=1)),
    "base_parameters": click.Choice(["file", "identify"]),
    "causes": several(CAUSE, metavar="CAUSE..."),
    "channels": COMMAS,
    "coefficient_sd": NumberRange(min=0.0),
    "compare": several(MODEL, metavar="MODEL..."),
    "directory": {"type": FILE, "flag": "-o --output"},
    "methods": several(METHOD, "--method"),
    "n0_rps": {"type": NUMBER, "flag": "--revolutions"},
    "particulars": FILE,
    "positive_rudder": SIDES,
    "reuse": several(FILE),
    "seeds": WholeRange(1, 1_000_000),
    "situations": WholeRange(1, 100_000),
    "step_s": {"type": NUMBER, "flag": "--dt"},
    "suite": SUITE,
    "vessels": several(VESSEL, "--vessel"),
    "worlds": WholeRange(1, 500),
}
"""Parameter of a public function -> type of its option, or settings of `click.Option` with `flag`: `-o --output`."""
ANNOTATED = {"bool": click.BOOL, "int": WholeRange(min=0), "float": NUMBER, "str": click.STRING}
"""Annotation of a parameter that is not among them -> type of its option."""
TWO_SETS = "train held_out positive_rudder"
GREEDY_SETS = ("--train", "--held-out")
EVERY_DAY = ("model", *TWO_SETS.split(), "output")
"""Names of the options of every day, of a command with training and held-out records."""


class ApiCommand(click.Command):
    """A command with options of a function of the API; the function is loaded when the options are asked for.

    api : public name of the function; empty: there is none.  options : its parameters that are options.  types : their
    types, where not those of `TYPES`.  greedy : options that take every value up to the next option (`--validate a.csv
    b.csv`).  common : names of the options of every day, with which the help begins; empty: all are.
    """

    def __init__(
        self,
        *args: Any,
        api: str,
        options: str,
        types: Mapping[str, Any],
        greedy: Sequence[str],
        common: Sequence[str],
        **settings: Any,
    ) -> None:
        super().__init__(*args, **settings)
        self._api, self._names, self._types, self._greedy, self._common = api, options.split(), types, greedy, common

    @cached_property
    def _options(self) -> list[click.Option]:
        return options_of(self._api, self._names, self._types) if self._api else []

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


class Output(NamedTuple):
    """Where the results of a command go: the help of `--output` and its default.

    writes : 'a file', 'a folder', or the public class whose files a folder gets: it is refused before anything is
        computed where it cannot be written or, without `--force`, exists.  Empty: the function sees to it.
    force : whether there is `--force` even so.
    """

    help: str
    default: str | None = None
    writes: str = ""
    force: bool = False

    def options(self) -> list[click.Option]:
        """`--output`, and `--force` where files are replaced."""
        place = click.Option(["-o", "--output"], default=self.default, show_default=True, type=FILE, help=self.help)
        force = click.Option(["--force"], is_flag=True, help="Replace files that exist.")
        return [place, force] if self.writes or self.force else [place]

    def refuse(self, output: Any, force: bool) -> None:
        """Raise BadInput where the output cannot be written, or exists."""
        import helmbench

        if self.writes in FILES:
            FILES[self.writes](output, force=force)
        elif self.writes:
            check_folder(output, getattr(helmbench, self.writes).files, force)


def command(
    api: str = "",
    options: str = "",
    output: Output | None = None,
    greedy: Sequence[str] = (),
    common: Sequence[str] = (),
    name: str | None = None,
    **types: Any,
) -> Callable[[Callable[..., Any]], ApiCommand]:
    """A command that shows a result as text or JSON: its function takes `printer`, and `output` where there is any.

    api, options, types, greedy, common : as of `ApiCommand`.
    """
    shown = [
        click.Option(["--json", "as_json"], is_flag=True, help="Print JSON for machines."),
        click.Option(["--quiet"], is_flag=True, help="Print only failures, and what --json asks for."),
    ]

    def made(function: Callable[..., Any]) -> ApiCommand:
        forces = "force" in inspect.signature(function).parameters

        @wraps(function)
        def printing(*, as_json: bool, quiet: bool, force: bool = False, **given: Any) -> Any:
            if output is not None:
                output.refuse(given["output"], force)
            return function(printer=Printer(as_json, quiet), **given, **({"force": force} if forces else {}))

        kept: dict[str, Any] = {"api": api, "options": options, "types": types, "greedy": greedy, "common": common}
        found = click.command(name, cls=ApiCommand, **kept)(printing)
        found.params += [*(output.options() if output is not None else ()), *shown]
        return found

    return made


def options_of(api: str, names: Sequence[str], types: Mapping[str, Any]) -> list[click.Option]:
    """The options of a public function for these of its parameters."""
    import helmbench

    function = getattr(helmbench, api)
    parameters, helps = inspect.signature(function).parameters, helps_of(function)
    every = {**TYPES, **types}
    return [_option(parameters[name], helps[name], every.get(name)) for name in names]


def helps_of(function: Any) -> dict[str, str]:
    """Parameter -> what the section `Parameters` of a docstring says of it."""
    section = (inspect.getdoc(function) or "").partition("Parameters\n----------\n")[2]
    entries = ENTRY.findall(re.split(r"^\w+\n-+\n", section, flags=re.MULTILINE)[0])
    return {name: " ".join(text.split()) for names, text in entries for name in names.split(", ")}


def _option(parameter: inspect.Parameter, text: str, own: Any) -> click.Option:
    if own is None:
        annotation = str(parameter.annotation)
        own = FILE if "Path" in annotation else ANNOTATED[annotation.partition(" ")[0]]
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
