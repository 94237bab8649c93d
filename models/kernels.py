"""Kernels on disk: generated once per version of the sources, compiled by numba with its cache.

The generated modules live in a folder keyed by the text of everything they are made from, so a warm start
reads a file and never imports SymPy.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import pkgutil
import sys
import tempfile
from functools import cache, lru_cache
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

from .errors import BadInput

ROOM = Path(__file__).parent
ENVIRONMENT = "+environment"


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@lru_cache
def cache_folder() -> Path:
    """Folder of generated kernels: HELMBENCH_CACHE, else the user's cache, else a temporary folder."""
    from platformdirs import user_cache_path

    named = os.environ.get("HELMBENCH_CACHE")
    home = Path(named) if named else user_cache_path("helmbench")
    scratch = Path(tempfile.gettempdir()) / f"helmbench-{os.getuid() if hasattr(os, 'getuid') else 'user'}"
    base = next((folder for folder in (home, scratch) if _writable(folder)), None)
    if base is None:
        raise BadInput(
            "no folder for compiled kernels can be written", file=home, hint="set HELMBENCH_CACHE to a writable folder"
        )
    return base / "kernels" / _key()


@lru_cache
def _key() -> str:
    sources = [ROOM / name for name in ("definition.py", "primitives.py", "generate.py")]
    sources += sorted((ROOM / "families").glob("*.py"))
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sources))
    digest.update(f"{sys.version_info[:2]} {version('numba')} {version('sympy')}".encode())
    return digest.hexdigest()[:16]


def definitions() -> dict:
    """Identifier -> function that builds the symbolic definition, from every module of `families`."""
    from . import families

    found = {}
    for module in sorted(pkgutil.iter_modules(families.__path__), key=lambda m: m.name):
        loaded = importlib.import_module(f"{families.__name__}.{module.name}")
        found |= getattr(loaded, "DEFINITIONS", {})
    return found


def _source(name: str) -> str:
    from .families.environment import with_environment
    from .generate import module_source

    builders, base = definitions(), name.removesuffix(ENVIRONMENT)
    if base not in builders:
        raise BadInput(f"unknown model family {base!r}", hint=f"known: {', '.join(sorted(builders))}")
    definition = builders[base]()
    return module_source(with_environment(definition) if name.endswith(ENVIRONMENT) else definition)


def _store(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "w") as stream:
        stream.write(text)
    os.utime(temporary, (1_000_000_000, 1_000_000_000))  # numba keys its index on the time stamp
    os.replace(temporary, path)


def _path(name: str) -> Path:
    return cache_folder() / f"{name.replace('+', '_').replace('-', '_')}.py"


def is_family(name: str) -> bool:
    """Whether a family has this identifier; asks SymPy only when its kernels were never generated."""
    return _path(name).exists() or name in definitions()


@cache
def load(name: str) -> ModuleType:
    """The generated module of a family (or of its `+environment` variant), compiled and ready.

    Raises
    ------
    BadInput : if no family has this name, or no cache folder can be written.
    """
    path = _path(name)
    if not path.exists():
        _store(path, _source(name))
    module_name = f"helmbench_kernels.{path.stem}_{_key()}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # before exec: else numba caches under <dynamic> and the next process crashes
    spec.loader.exec_module(module)
    return module
