"""Packages that come with an extra: where one is missing, the message says what to install."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager

from .errors import BadInput

EXTRAS: Mapping[str, str] = {
    "pyarrow": "parquet",
    "pandas": "pandas",
    "torch": "gp",
    **dict.fromkeys(("cmaes", "joblib", "optuna", "sklearn"), "bench"),
    "jax": "deep",
    "distributed": "distributed",
    "weasyprint": "pdf",
    "emcee": "bayes",
    **dict.fromkeys(("starlette", "uvicorn"), "open"),
    **dict.fromkeys(("h5py", "nmea2000", "pymavlink", "pyulog", "rosbags"), "readers"),
    "identibench": "identibench",
}
"""Import name of a package -> the extra of helmbench that brings it."""


INSTALL = "pip install 'helmbench["
"""How a message says that an extra is missing."""


def missing(error: ImportError) -> str:
    """What to install for a module that was not found; raises the error again where no extra brings it."""
    package = (error.name or "").partition(".")[0]
    if package not in EXTRAS:
        raise error
    return f"this needs {package}: {INSTALL}{EXTRAS[package]}]'"


def missing_here(error: ModuleNotFoundError) -> str:
    """The same, also for a package that no extra brings: one of the base where an installation is not whole, or Python
    was started in a checkout that is not installed for it; raises the error again for a module of helmbench."""
    package = (error.name or "").partition(".")[0]
    if package in EXTRAS or package == "helmbench":
        return missing(error)
    return f"{package} is not installed; 'python -m pip install .' in helmbench's folder installs what helmbench needs"


@contextmanager
def extras_told(kind: Callable[[str], Exception] = BadInput) -> Generator[None]:
    """Raise `kind` with what to install where the enclosed code imports a package of an extra that is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise kind(missing(error)) from None
