"""helmbench: benchmark and diagnosis of methods that identify ship manoeuvring models from records.

This is the public face. Every name below is loaded on first use, so that `import helmbench` costs next to nothing:

    import helmbench

    model = helmbench.resolve("mariner")
    record = helmbench.generate(helmbench.Case("mariner", "zigzag:20/20", noise="low", seed=1))
    estimate = helmbench.make_method("ls").fit([record], model.blanked())
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .datasets.generator import Case, generate
    from .datasets.io import read_record, write_record
    from .datasets.record import Record
    from .estimation.estimate import Estimate
    from .methods.registry import make as make_method
    from .methods.registry import methods as list_methods
    from .models.errors import BadInput
    from .models.model import Model, resolve
    from .models.simulate import simulate

    __version__: str

__all__ = [
    "BadInput",
    "Case",
    "Estimate",
    "Model",
    "Record",
    "__version__",
    "generate",
    "list_methods",
    "make_method",
    "read_record",
    "resolve",
    "simulate",
    "write_record",
]

# public name -> (module below helmbench, name there)
_HOME = {
    "BadInput": ("models.errors", "BadInput"),
    "Case": ("datasets.generator", "Case"),
    "Estimate": ("estimation.estimate", "Estimate"),
    "Model": ("models.model", "Model"),
    "Record": ("datasets.record", "Record"),
    "generate": ("datasets.generator", "generate"),
    "list_methods": ("methods.registry", "methods"),
    "make_method": ("methods.registry", "make"),
    "read_record": ("datasets.io", "read_record"),
    "resolve": ("models.model", "resolve"),
    "simulate": ("models.simulate", "simulate"),
    "write_record": ("datasets.io", "write_record"),
}


def _load(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("helmbench")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOME[name]
    return getattr(import_module(f"{__name__}.{module}"), attribute)


def __getattr__(name: str) -> Any:
    value = globals()[name] = _load(name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
