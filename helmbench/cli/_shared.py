"""What commands share: options, exit statuses, output, and checks of the place that results go to."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, ParamSpec, TypeVar

import click
from click.shell_completion import CompletionItem

P = ParamSpec("P")
R = TypeVar("R")

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
SIDES = click.Choice(["port", "starboard"])
FORMATS = click.Choice(["simulink", "vehicle-simulator", "mmgdynamics", "gazebo", "fmu"])
LONGEST = 200
"""Characters of a summary; a longer one would be cut by an ellipsis."""
TUNERS = click.Choice(["abc", "tpe", "cmaes", "gp", "grid", "random"])


class _FilePath(click.Path):
    """A path whose name is UTF-8 text; another could not be named in any result."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        path = super().convert(value, param, ctx)
        try:
            str(path).encode()
        except UnicodeEncodeError:
            self.fail(f"{str(path)!a}: the name is not UTF-8 text; rename the file", param, ctx)
        return path


FILE = _FilePath(path_type=Path)


class _InDigits(click.ParamType[Any]):
    """A number in ASCII digits, finite."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from ..models.number_texts import number_of, whole_of

        try:
            read = whole_of if isinstance(self, click.IntRange) else number_of
            return super().convert(read(value) if isinstance(value, str) else value, param, ctx)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Number(_InDigits, click.types.FloatParamType):
    """A number."""


class NumberRange(_InDigits, click.FloatRange):
    """A number within bounds."""


class WholeRange(_InDigits, click.IntRange):
    """A whole number within bounds."""


NUMBER = Number()


class Identifier(click.ParamType[str]):
    """A text that may be an identifier of `helmbench list KIND`, which the shell completes; anything is taken.

    more : further texts that are completed.
    """

    name = "text"

    def __init__(self, *kinds: str, more: Sequence[str] = ()) -> None:
        self.kinds, self.more = kinds, more

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Identifiers that begin with what was typed, with their titles; files where none does."""
        import helmbench

        titles = dict.fromkeys(self.more, "")
        for kind in self.kinds:
            titles |= getattr(helmbench, f"list_{kind}")()
        known = [CompletionItem(name, help=title) for name, title in titles.items() if name.startswith(incomplete)]
        return known or [CompletionItem(incomplete, type="file")]


METHOD, VESSEL, SUITE, CAUSE = (Identifier(kind) for kind in ("methods", "vessels", "suites", "causes"))
MODEL = Identifier("vessels", "models")
MODEL_OR_AUTO = Identifier("vessels", "models", more=["auto"])


class CommandGroup(click.Group):
    """A group whose help shows every command with its whole summary, in the order in which they were added.

    sections : heading of the help -> its commands.
    """

    sections: ClassVar[Mapping[str, Sequence[click.Command]]] = {}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of the help."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands below their headings, aligned over all of them."""
        width = max(map(len, self.commands))
        for heading, commands in (self.sections or {"Commands": [*self.commands.values()]}).items():
            with formatter.section(heading):
                formatter.write_dl([(f"{c.name:{width}}", c.get_short_help_str(limit=LONGEST)) for c in commands])


def spread(args: Iterable[str], greedy: Sequence[str]) -> list[str]:
    """`--x a b` as `--x a --x b` for the options in `greedy`."""
    out: list[str] = []
    current, repeat = "", False
    for arg in args:
        if arg.startswith("-") and arg != "-":
            current, repeat = arg, False
        elif current in greedy:
            out += [current] if repeat else []
            repeat = True
        out.append(arg)
    return out


class Commas(click.ParamType[list[str]]):
    """Names with commas between them."""

    name = "names"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> list[str]:
        return [name.strip() for name in value.split(",")] if isinstance(value, str) else value


COMMAS = Commas()


RESULTS, RECORD = "directory of the results", "record.csv or .parquet to write"
"""What `--output` of several commands is."""


def tuning_options(function: Callable[P, R]) -> Callable[P, R]:
    """Add `--tuner` and `--storage`."""
    where = "Where tuning studies are stored and shared: PATH.journal or sqlite:///PATH; default: in memory."
    function = click.option("--storage", help=where)(function)
    return click.option("--tuner", type=TUNERS, help="Tune the options that the methods declare.")(function)


@dataclass(frozen=True)
class Printer:
    """How a command shows what it found: as JSON, as text with the files that it wrote, or not at all."""

    as_json: bool
    quiet: bool

    @property
    def hidden(self) -> bool:
        """Whether no text is shown."""
        return self.as_json or self.quiet

    @property
    def progress(self) -> bool:
        """Whether a progress bar is shown: only on a terminal."""
        return not self.hidden and sys.stderr.isatty()

    def show(
        self,
        plain: Callable[[], Any],
        text: Callable[[], str] | None = None,
        files: Iterable[Path] = (),
    ) -> None:
        """Print the plain values, or the text and the files."""
        if self.as_json:
            print_json(plain())
        elif not self.quiet:
            if text is not None:
                echo(text())
            show_files(files)


def complain(message: str, status: int) -> int:
    """Print one line on standard error; returns the status."""
    echo(f"helmbench: {' '.join(message.split())}", err=True)
    return status


def echo(text: str, err: bool = False) -> None:
    """Print a text on standard output (err: error); what would steer a terminal is shown as an escape."""
    from ..models.errors import visible

    click.echo(visible(text, kept="\n\t"), err=err)


def confirmed(question: str) -> bool:
    """Whether the user says yes, on a terminal."""
    from ..models.errors import visible

    return click.confirm(visible(question), err=True)


def print_json(value: Any) -> None:
    """Print a value as JSON; what is not a finite number is null."""
    from ..models.plain import json_text

    echo(json_text(value))


def show_files(paths: Iterable[Path]) -> None:
    """Say on standard error which files were written."""
    for path in paths:
        echo(f"wrote {path}", err=True)


@contextmanager
def fit_told(refused: str, failed: str = "") -> Generator[None]:
    """Say what cannot be done: `refused` before the reason where a fit does not apply, which is bad input; `failed`
    (empty: the same) where it fails, which ends with status 1."""
    from .. import BadInput, CannotFit, FitFailed

    try:
        yield
    except CannotFit as reason:
        raise BadInput(f"{refused}: {reason}") from None
    except FitFailed as reason:
        raise click.ClickException(f"{failed or refused}: {reason}") from None


def check_file(output: Path | None, force: bool = False) -> None:
    """Refuse an output file, if there is one, that cannot be written or exists, before anything is computed."""
    from .. import BadInput
    from ..models.files import refuse_existing

    if output is None:
        return
    if output.exists() and not output.is_file():
        told = "is a directory" if output.is_dir() else "is a device or a pipe"
        raise BadInput(told, file=output, hint="give the name of a file with -o")
    _check_place(output.parent)
    if not force:
        refuse_existing([output])


def check_folder(output: Path | None, names: Iterable[str] = (), force: bool = False) -> None:
    """Refuse an output directory, if there is one, that cannot be made or that holds files of these names."""
    from .. import BadInput
    from ..models.files import refuse_existing

    if output is None:
        return
    if output.exists() and not output.is_dir():
        raise BadInput("is a file", file=output, hint="give a directory with -o")
    _check_place(output if output.exists() else output.parent)
    if not force:
        refuse_existing(output / name for name in names)


def _check_place(folder: Path) -> None:
    """Refuse a directory that does not exist or cannot be written to."""
    from .. import BadInput

    if not folder.resolve().is_dir():
        raise BadInput("no such directory", file=folder)
    if not os.access(folder.resolve(), os.W_OK):
        raise BadInput("cannot be written to", file=folder, hint="give another place with -o")
