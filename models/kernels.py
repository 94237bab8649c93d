"""Kernels on disk: generated once per version of the sources, compiled by numba with its cache.

An index keyed by the text of everything the generated modules are made from says where they are, so a warm start
reads files and never imports SymPy.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable, Mapping
from functools import cache, lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar

from .cache import VARIABLE, building, cache_folder, close_folder, store, stored
from .errors import BadInput, EnvironmentFault

if TYPE_CHECKING:
    from .definition import Definition

ROOM = Path(__file__).parent
ENVIRONMENT, PUSHED = "+environment", "+pushed"
BANK = "+bank"


@lru_cache
def _key() -> str:
    """What all generated text depends on: the sources and the versions of what reads them."""
    sources = [ROOM / name for name in ("definition.py", "primitives.py", "generate.py")]
    sources += sorted(path for path in (ROOM / "families").glob("*.*") if path.suffix in (".py", ".yaml"))
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sources))
    digest.update(_versions().encode())
    return digest.hexdigest()[:16]


def _versions() -> str:
    return f"{sys.version_info[:2]} {version('numba')} {version('sympy')}"


@cache
def definitions() -> Mapping[str, Callable[[], Definition]]:
    """Identifier -> function that builds the symbolic definition, from `families/definitions.yaml`."""
    from .data_file import load
    from .definition import written

    rows = load(ROOM / "families" / "definitions.yaml")
    return {name: partial(written, name=name, **row) for name, row in rows.items()}


def catalogue() -> dict[str, dict[str, Any]]:
    """Family id -> `title`, and the names of its `constants`; kept beside the kernels, without SymPy where it is."""
    index = _index("catalogue")
    try:
        return json.loads(stored(index) or b"")
    except ValueError:
        built = {name: build() for name, build in sorted(definitions().items())}
    found = {name: {"title": one.title, "constants": [c.name for c in one.constants]} for name, one in built.items()}
    _close(index.parent)
    _keep({index: json.dumps(found)})
    return found


def _generate(name: str) -> dict[str, str]:
    from .families.bank import with_bank
    from .families.environment import with_environment, with_push
    from .generate import bank_sources, sources

    base, bank, terms = name.partition(BANK)
    if bank:
        return bank_sources(with_bank(definition_of(base), terms.split("~")[1:]))
    if name.endswith(PUSHED):
        return sources(with_push(definition_of(name.removesuffix(PUSHED))))
    definition = definition_of(name.removesuffix(ENVIRONMENT))
    if name.endswith(ENVIRONMENT) and definition.force_scale is None:
        raise BadInput(f"family {definition.name!r} has no environment variant", hint="it takes a 3-DOF family")
    return sources(with_environment(definition) if name.endswith(ENVIRONMENT) else definition)


def definition_of(name: str) -> Definition:
    """The symbolic definition of a family id, which may carry extensions: `abkowitz+rudder_offset`.

    Raises
    ------
    BadInput : if there is no such family or extension, or the family cannot carry it.
    """
    from .families.extensions import carries, extended, extensions, is_made_up

    base, *extras = name.split("+")
    builders = definitions()
    if base not in builders:
        raise BadInput(f"unknown model family {base!r}", hint=f"known: {', '.join(sorted(builders))}")
    definition = builders[base]()
    for extra in extras:
        if extra not in extensions() and not is_made_up(extra):
            raise BadInput(f"unknown extension {extra!r} of {base}", hint=f"known: {', '.join(sorted(extensions()))}")
        if not carries(definition, extra):
            raise BadInput(f"family {definition.name!r} cannot carry the extension {extra!r}")
        definition = extended(definition, extra)
    return definition


def _index(name: str) -> Path:
    return cache_folder() / _key() / f"{name}.json"


def _files(name: str) -> dict[str, str]:
    """Part -> file name of a family's modules, generated if need be.

    Files are named by their content: a change of one family leaves the compiled kernels of the others in place.
    """
    found = _indexed(name)
    if found is None:
        index = _index(name)
        _close(index.parent)
        with building(index):
            found = _indexed(name) or _made(name)
    return found


def _close(folder: Path) -> None:
    try:
        close_folder(folder)
    except OSError as error:
        hint = f"remove it, or set {VARIABLE} to another folder"
        raise EnvironmentFault(f"cannot be used ({error})", file=folder, hint=hint) from None


def _indexed(name: str) -> dict[str, str] | None:
    """The index of a family whose files are all there and whole; else None."""
    try:
        files = json.loads(stored(_index(name)) or b"")
    except ValueError:
        return None
    return files if all(_text(file) is not None for file in files.values()) else None


def _text(file: str) -> str | None:
    """A generated module; None where it is missing, damaged or not the one that the file is named by."""
    data = stored(cache_folder() / Path(file).name)
    text = None if data is None else data.decode(errors="replace")
    return text if text is not None and file.endswith(f"_{_named_by(text)}.kernel") else None


def _named_by(text: str) -> str:
    return hashlib.sha256((_versions() + text).encode()).hexdigest()[:16]


def _made(name: str) -> dict[str, str]:
    """Generate a family's modules and its index."""
    texts = _generate(name)
    stem = re.sub("[^a-z0-9_]", "_", name.lower())
    files = {part: f"{stem}_{part}_{_named_by(text)}.kernel" for part, text in texts.items()}
    _keep({**{cache_folder() / file: texts[part] for part, file in files.items()}, _index(name): json.dumps(files)})
    return files


def _keep(texts: dict[Path, str]) -> None:
    """Write files of the cache, in this order."""
    try:
        for path, text in texts.items():
            store(path, text.encode())
    except OSError as error:
        hint = f"free some space, or set {VARIABLE} to another folder"
        fault = f"generated code cannot be kept ({error.strerror or error})"
        raise EnvironmentFault(fault, file=cache_folder(), hint=hint) from None


def is_family(name: str) -> bool:
    """Whether a family, extended or not, has this identifier; asks SymPy only for kernels never generated.

    Whether the family can carry its extensions is found by `load`.
    """
    if name.endswith((ENVIRONMENT, PUSHED)) or BANK in name:
        return False
    return stored(_index(name)) is not None or name.split("+")[0] in catalogue()


class Kernels:
    """The generated code of one family: facts and compiled functions as attributes, each part loaded at first use."""

    PARTS: ClassVar = {
        **{"simulate": "simulate", "tangent": "tangent", "JT_COLUMN": "tangent", "JT_ROW": "tangent"},
        **{"rhs_lanes": "lanes", "prepare_lanes": "lanes", "LANE_NUMBERS": "lanes"},
        **{"regress": "regress", "jacobian": "jacobian"},
    }

    def __init__(self, name: str) -> None:
        self.name, self._found = name, _files(name)

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("_"):
            raise AttributeError(attribute)
        value = getattr(_module(self._found[self.PARTS.get(attribute, "core")]), attribute)
        setattr(self, attribute, value)
        return value


@cache
def load(name: str) -> Kernels:
    """The kernels of a family, or of its `+environment` variant, of a response model its `+pushed` variant.

    Raises
    ------
    BadInput : if no family has this name, or no cache folder can be written.
    """
    check_family_name(name)
    return Kernels(name)


def carries(family: str, extension: str) -> bool:
    """Whether a family can carry an extension that it does not have yet, by its generated facts."""
    from .families.extensions import fits

    own = load(family)
    numbers = (*own.COEFFICIENTS, *own.CONSTANTS)
    return fits(extension, numbers, own.REGRESSION_STATES, own.HELPERS, three_dof=own.ENVIRONMENT)


@cache
def _module(file: str) -> ModuleType:
    path = cache_folder() / file
    module = ModuleType(f"helmbench_kernels.{path.stem}")
    text = _text(file)
    if text is None:
        raise EnvironmentFault(
            "generated code was removed or damaged while it was in use", file=path, hint="start again"
        )
    sys.modules[module.__name__] = module  # numba finds the module of a cached function by its name
    exec(compile(text, str(path), "exec"), vars(module))
    return module


# ---- What an identifier of a family of equations may look like: nothing else is looked up, least of all on the disk.

MOST_LETTERS = 200
_WORD = "[A-Za-z0-9_]+"
_NAME = re.compile(rf"[a-z0-9]+(-[a-z0-9]+)*(\+{_WORD})*(~{_WORD})*")


def is_family_name(name: object) -> bool:
    """Whether a text has the form of an identifier: `nomoto-1`, `abkowitz+rudder_offset`."""
    return isinstance(name, str) and len(name) <= MOST_LETTERS and _NAME.fullmatch(name) is not None


def check_family_name(name: object, file: object = None) -> None:
    """Refuse what cannot be the identifier of a family, such as a path; BadInput names the file that it stands in."""
    if not is_family_name(name):
        shown = repr(name)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
        raise BadInput(f"unknown model family {shown}", file=file, hint="'helmbench list models' shows the families")
