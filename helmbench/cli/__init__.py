"""The command line: parses, calls what `import helmbench` offers, prints.

Nothing heavy is imported before a command needs it.  Exit status: 0 done, 1 finished but some runs failed (they are
listed) or `check` names what matters, 2 bad input (one line, nothing written).
"""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import ClassVar, NoReturn

import click

from ._shared import BAD_INPUT, INTERRUPTED, OK, CommandGroup, complain, echo
from .benchmark import advice, compare, exam, fetch, identibench, merge, report, reproduce, run
from .import_ import import_command
from .installation import completion, doctor, open_command
from .models import export, from_indices, import_model, list_command, simulate
from .records import calibrate, check, diagnose, identify, validate


class _Cli(CommandGroup):
    """The command line, its commands by what they are for."""

    sections: ClassVar = {
        "Your record": (
            *(open_command, import_command, check, identify, validate),
            *(diagnose, calibrate, from_indices),
        ),
        "Models": (list_command, simulate, export, import_model),
        "Benchmark": (run, report, compare, merge, advice, exam, reproduce, identibench, fetch),
        "This installation": (doctor, completion),
    }


@click.group(cls=_Cli, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="helmbench", prog_name="helmbench")
def cli() -> None:
    """Identify ship, USV and AUV manoeuvring models from records, diagnose simulations, benchmark methods."""


NUMBA_SETTINGS = Path(".numba_config.yaml")
"""File of the working folder that numba reads by itself: it may say where compiled code is taken from."""
RESUMED = ("run", "reproduce")
"""Commands that go on with --resume after an interruption."""
for command in chain.from_iterable(_Cli.sections.values()):
    cli.add_command(command)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave with its exit status."""
    _stop_on_signals()
    warnings.formatwarning = _warning  # ty: ignore[invalid-assignment] (it takes no function but the original)
    sys.exit(status_of(arguments))


def status_of(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; bad input becomes one line on standard error and status 2."""
    given = [*(sys.argv[1:] if arguments is None else arguments)]
    if NUMBA_SETTINGS.exists():
        return complain(f"{NUMBA_SETTINGS}: numba would follow these settings; remove it, or work elsewhere", BAD_INPUT)
    try:
        result: object = cli.main(args=given, prog_name="helmbench", standalone_mode=False)
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except (click.Abort, KeyboardInterrupt) as stop:
        return complain(_interruption(given), _status(stop))
    except click.exceptions.NoArgsIsHelpError as error:
        echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return complain(error.format_message(), error.exit_code)
    except MemoryError as error:
        return complain(f"not enough memory ({error or 'the machine refused more'})", BAD_INPUT)
    except ModuleNotFoundError as error:
        from ..models.extras import missing_here

        return complain(missing_here(error), BAD_INPUT)
    except OSError as error:
        return complain(_refusal(error), BAD_INPUT)
    except ValueError as error:
        from .. import BadInput

        if not isinstance(error, BadInput):
            raise
        return complain(str(error), BAD_INPUT)
    return result if isinstance(result, int) else OK


def _warning(message: Warning | str, *_: object, **__: object) -> str:
    """A warning in one line, without the place in the code that it came from."""
    from ..models.errors import visible

    return f"helmbench: warning: {visible(str(message), kept=chr(10))}\n"


class _Stopped(KeyboardInterrupt):
    """The system asked this process to end."""

    def __init__(self, number: int) -> None:
        self.number = number


def _stop_on_signals() -> None:
    """Let SIGTERM and SIGHUP end the command as Ctrl-C does; a signal that is ignored stays so (nohup)."""

    def stop(number: int, _: object) -> None:
        raise _Stopped(number)

    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, stop)


def _interruption(arguments: Sequence[str]) -> str:
    resumable = arguments and arguments[0] in RESUMED
    return "interrupted (a run is continued with --resume)" if resumable else "interrupted"


def _status(stop: BaseException) -> int:
    """130 for Ctrl-C, for another signal 128 and its number."""
    cause = stop.__cause__ if isinstance(stop, click.Abort) else stop
    return 128 + cause.number if isinstance(cause, _Stopped) else INTERRUPTED


def _refusal(error: OSError) -> str:
    """What the system refused, in one line."""
    names = [str(name) for name in (error.filename, error.filename2) if name is not None]
    return ": ".join([*names[:1], error.strerror or str(error)])
