"""The command line: parses, calls what `import helmbench` offers, prints.  One file a command.

Nothing heavy is imported before a command needs it.  Exit status: 0 done, 1 finished but some runs failed (they are
listed), 2 bad input (one line, nothing written).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import NoReturn

import click

from ._shared import BAD_INPUT, INTERRUPTED, OK, complain
from .calibrate import calibrate
from .check import check
from .completion import completion
from .diagnose import diagnose
from .doctor import doctor
from .fetch import fetch
from .identify import identify
from .import_ import import_command
from .list import list_command
from .report import report
from .reproduce import reproduce
from .run import run
from .simulate import simulate
from .validate import validate


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="helmbench", prog_name="helmbench")
def cli() -> None:
    """Benchmark methods that identify ship, USV and AUV manoeuvring models from records."""


COMMANDS = (
    *(list_command, import_command, simulate, check, identify, validate, diagnose, calibrate),
    *(run, report, reproduce, fetch, doctor, completion),
)
for command in COMMANDS:
    cli.add_command(command)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave with its exit status."""
    sys.exit(status_of(arguments))


def status_of(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; bad input becomes one line on standard error and status 2."""
    try:
        result: object = cli.main(args=arguments, prog_name="helmbench", standalone_mode=False)
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except (click.Abort, KeyboardInterrupt):
        return complain("interrupted (a run is continued with --resume)", INTERRUPTED)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return complain(error.format_message(), BAD_INPUT)
    except (ValueError, OSError) as error:
        if not _is_bad_input(error):
            raise
        return complain(str(error), BAD_INPUT)
    return result if isinstance(result, int) else OK


def _is_bad_input(error: Exception) -> bool:
    """Whether the user's input is at fault: the code says so, or the system refuses a file."""
    from .. import BadInput

    return isinstance(error, BadInput) or (isinstance(error, OSError) and error.filename is not None)
