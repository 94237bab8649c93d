"""helmbench: benchmark and diagnosis of methods that identify ship manoeuvring models from records.

`import helmbench` offers the names of `__init__.pyi`.  Each is loaded when it is first used, so that the import itself
is quick:

    import helmbench

    record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1)
    estimate = helmbench.identify(record, "mariner", "ls")
    print(estimate.parameters, estimate.stderr)

SI units and radians throughout, unless a name says otherwise.
"""

import os
import sys

if (  # of `python -m helmbench` the working folder leaves the path, unless this package lies there
    sys.argv[:1] == ["-m"]
    and sys.orig_argv[-len(sys.argv)].partition(".")[0].endswith("helmbench")
    and sys.path[0] == os.getcwd() != os.path.dirname(__path__[0])
):
    del sys.path[0]

from importlib import import_module
from pathlib import Path
from typing import Any

# Python that is started in a checkout takes this folder before an installed package: the rooms stand beside it there.
if not Path(__file__).with_name("models").is_dir():
    __path__.append(str(Path(__file__).resolve().parents[1]))

_IMPORTS = (
    line.removeprefix("from .").split(" import ")
    for line in Path(__file__).with_suffix(".pyi").read_text("utf-8").splitlines()
    if line.startswith("from .")
)
_HOME = {
    own: (module, name)
    for module, names in _IMPORTS
    for name, _, own in (text.partition(" as ") for text in names.split(", "))
}
"""Public name -> module, and its name there."""
__all__ = sorted(["__version__", *_HOME])


def _load(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("helmbench")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOME[name]
    try:
        return getattr(import_module(f"{__name__}.{module}"), attribute)
    except ModuleNotFoundError as error:
        from .models.extras import missing_here

        raise ModuleNotFoundError(missing_here(error), name=error.name) from None


def __getattr__(name: str) -> Any:
    value = globals()[name] = _load(name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
