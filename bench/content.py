"""What a result depends on, as a digest: results that are stored can stand for runs with the same one.

Of the sources only those count that a method and its run import, and what they import in turn, as their texts say; of
other packages the versions.  The rooms `models` and `datasets` count as a whole, with their data.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = __name__.partition(".")[0]
WHOLE_ROOMS = ("models", "datasets")
ALWAYS = ("numpy", "scipy", "numba", "sympy")


@lru_cache(maxsize=256)
def sources_digest(*start: str) -> str | None:
    """Digest of everything that modules and Python files depend on; None where that cannot be said: a file imports
    something that belongs to no installed package.

    start : names of modules of this package, of other packages, or paths of Python files.
    """
    files, packages = _reached(start)
    versions = [_version(name) for name in sorted(packages | set(ALWAYS))]
    if None in versions:
        return None
    digests = [_file_digest(path) for path in sorted(files | _room_files(), key=str)]
    return hashlib.sha256(f"{sys.version_info[:2]}{versions}{digests}".encode()).hexdigest()[:20]


@lru_cache(maxsize=1)
def _room_files() -> frozenset[Path]:
    kinds = (".py", ".yaml", ".json")
    return frozenset(path for room in WHOLE_ROOMS for path in (ROOT / room).rglob("*") if path.suffix in kinds)


@lru_cache(maxsize=1024)
def _file_digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _reached(start: Iterable[str]) -> tuple[set[Path], set[str]]:
    """Files of this package (and those given) that are imported from the start on, and other top-level modules."""
    queue, files, packages = list(start), set[Path](), set[str]()
    while queue:
        name = queue.pop()
        if not (name.startswith(PACKAGE + ".") or name.endswith(".py")):
            packages.add(name.partition(".")[0])
        elif (path := _file(name)) is not None and path not in files:
            files.add(path)
            queue.extend(_imported(name, path))
    return files, packages - set(sys.stdlib_module_names) - {PACKAGE, ""}


@lru_cache(maxsize=4096)
def _file(name: str) -> Path | None:
    """The file of a module of this package, or a given file; None for a name that is no module.

    Only packages are imported: `find_spec` would import a module to look for what it is asked for in it.
    """
    if name.endswith(".py"):
        return Path(name).resolve()
    parent = name.rpartition(".")[0]
    if parent and ((above := _file(parent)) is None or above.name != "__init__.py"):
        return None
    try:
        spec = find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin else None


@lru_cache(maxsize=1024)
def _imported(module: str, path: Path) -> tuple[str, ...]:
    """Names that a file imports, anywhere in it; what follows `from ... import` may be modules or not."""
    return tuple(_names(module, path))


def _names(module: str, path: Path) -> Iterator[str]:
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in _statements(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)


def _statements(block: ast.AST) -> Iterator[ast.AST]:
    """The statements in a block and in the blocks of each; expressions, most of the text, hold no import."""
    for name in ("body", "handlers", "cases", "orelse", "finalbody"):
        for inner in getattr(block, name, ()):
            yield inner
            yield from _statements(inner)


@lru_cache(maxsize=256)
def _version(module: str) -> str | None:
    """Version of the package that a top-level module belongs to; of an optional package that is absent, its absence."""
    try:
        return f"{module} {version(_distributions().get(module, (module,))[0])}"
    except PackageNotFoundError:
        return f"{module} is absent" if find_spec(module) is None else None


@lru_cache(maxsize=1)
def _distributions() -> dict[str, list[str]]:
    return dict(packages_distributions())
