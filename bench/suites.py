"""Suites as data: which vessels, methods, manoeuvres, noise levels, disturbances and seeds are run.

A suite is a YAML file with a `title` and a list of `entries`; every entry is a full product of its lists.

    vessels       ids, or one of `all`, `3dof`, `response` (every vessel of that kind)
    dataset       instead of vessels: a measured set; `train` and `held_out` then hold its record names
    models        families to fit; `own` is the vessel's own (default)
    methods       method texts (`ls`, `ls,scheme=midpoint`, `rls,variant=as_printed`, `path.py:Class`); `all` stands for
                  every method of the registry
    open          false: only these methods, also when `--method` asks for others (default true)
    train         manoeuvres of the training records (default: the vessel file's); a list of lists makes one row of each
    held_out      manoeuvres to predict (default: the vessel file's); likewise
    euler         true: training records are made by the explicit Euler difference equation
    noise, disturbance    lists of strings
    thinning      whole numbers: every how many-th sample of the training records is kept (default 1)
    length        shares of the training records that are kept, from their start (default 1)
    seeds, duration_s, dt_s    a number of seeds, and settings of the training records

A suite of `kind: diagnosis` injects effects in simulated records and scores what diagnosers say.  It also has `seeds`,
the number of rounds, `methods`, the diagnosers (`innovations`, `path.py:Class`, ...), and `compare`, those that take
part in the first round only.  Its entries are stratified draws: every round injects each text of `inject` `each` times;
vessel, strength and gusts are drawn so that each value comes once before any comes again.

    group         injected, null, anticipated, unforeseen or pair: how the answer is scored
    inject        causes joined by +, `none`, or all `causes`, `anticipated` or `unforeseen` kinds
    vessels       ids (default: those of the truth simulator); those that cannot carry a cause are left out
    strength, gusts    lists of names (`faults.strength`, `faults.case`); each: cases of each text a round (default 1)
    oracle        true: the true causes are refitted as well, to compare the gain with (default false)
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from ..models.errors import BadInput
from .store import DIAGNOSIS, IDENTIFICATION

FOLDER = Path(__file__).parent / "suites"
GROUPS = ("all", "3dof", "response")
INJECTION_GROUPS = ("injected", "null", "anticipated", "unforeseen", "pair")


@dataclass(frozen=True)
class Entry:
    """One product of lists; the module docstring says what each field means."""

    vessels: tuple[str, ...] = ("all",)
    dataset: str | None = None
    models: tuple[str, ...] = ("own",)
    methods: tuple[str, ...] = ("all",)
    open: bool = True
    train: tuple[tuple[str, ...], ...] = ()
    held_out: tuple[tuple[str, ...], ...] = ()
    euler: bool = False
    noise: tuple[str, ...] = ("none",)
    disturbance: tuple[str, ...] = ("none",)
    thinning: tuple[int, ...] = (1,)
    length: tuple[float, ...] = (1.0,)
    seeds: int = 1
    duration_s: float | None = None
    dt_s: float | None = None


@dataclass(frozen=True)
class InjectionEntry:
    """Cases of a diagnosis suite; the module docstring says what each field means."""

    group: str = "injected"
    inject: tuple[str, ...] = ("causes",)
    vessels: tuple[str, ...] = ()
    strength: tuple[str, ...] = ("medium",)
    gusts: tuple[str, ...] = ("none",)
    each: int = 1
    oracle: bool = False


ENTRIES = {IDENTIFICATION: Entry, DIAGNOSIS: InjectionEntry}


@dataclass(frozen=True)
class Suite:
    """A named list of entries; `digest` changes with the file's content.

    `kind` says what the entries are: `Entry` (identification) or `InjectionEntry` (diagnosis), and only for the latter
    have `seeds`, `methods` and `compare` a meaning here.
    """

    name: str
    title: str
    digest: str
    entries: tuple[Any, ...] = field(repr=False)
    kind: str = IDENTIFICATION
    seeds: int = 1
    methods: tuple[str, ...] = ()
    compare: tuple[str, ...] = ()


def suite_names() -> list[str]:
    """Names of the suites that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def load_suite(name: str) -> Suite:
    """A shipped suite by its name, or a suite file by its path.

    Raises `BadInput` where there is no such suite or the file does not follow the module docstring.
    """
    path = Path(name) if name.endswith((".yaml", ".yml")) else FOLDER / f"{name}.yaml"
    if not path.is_file():
        hint = f"known: {', '.join(suite_names())}, or the path of a .yaml file"
        raise BadInput(f"unknown suite {name!r}", hint=hint)
    text = path.read_bytes()
    content = _parse(text, path)
    entries = content.get("entries")
    if not isinstance(entries, list) or not entries:
        raise BadInput("has no list of entries", file=path)
    kind = content.get("kind", IDENTIFICATION)
    if kind not in ENTRIES:
        raise BadInput(f"unknown kind {kind!r}", file=path, hint=f"known: {', '.join(ENTRIES)}")
    facts = {}
    if kind == DIAGNOSIS:
        facts["seeds"] = _count(content.get("seeds", 1), f"{path}: seeds")
        facts["methods"] = _texts(content.get("methods"), f"{path}: methods")
        facts["compare"] = _texts(content["compare"], f"{path}: compare") if "compare" in content else ()
    digest = hashlib.sha256(text).hexdigest()[:16]
    rows = tuple(_entry(ENTRIES[kind], entry, path, number) for number, entry in enumerate(entries, start=1))
    return Suite(path.stem, str(content.get("title", path.stem)), digest, rows, kind, **facts)


def _parse(text: bytes, path: Path) -> dict[str, Any]:
    import yaml

    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BadInput(f"is not YAML ({error})", file=path) from None
    if not isinstance(content, dict):
        raise BadInput("is not a suite", file=path, hint="a suite has a title and entries")
    return content


def _entry(cls: type[Entry] | type[InjectionEntry], raw: Any, path: Path, number: int) -> Entry | InjectionEntry:
    """One validated entry; every complaint names the file and the entry."""
    where = f"{path}: entry {number}"
    if not isinstance(raw, dict):
        raise BadInput("is not a mapping", file=where)
    known = [entry.name for entry in fields(cls)]
    unknown = sorted(str(key) for key in raw if key not in known)
    if unknown:
        raise BadInput(f"unknown key {unknown[0]!r}", file=where, hint=f"known: {', '.join(known)}")
    if "dataset" in raw and not (raw.get("train") and raw.get("held_out")):
        raise BadInput("a dataset entry needs train and held_out", file=where)
    readers = {
        "train": _groups,
        "held_out": _groups,
        "open": _flag,
        "euler": _flag,
        "seeds": _count,
        "thinning": _each(_count),
        "length": _each(_share),
        "dataset": _text,
        "duration_s": _positive,
        "dt_s": _positive,
        "group": _group,
        "each": _count,
        "oracle": _flag,
    }
    return cls(**{key: readers.get(key, _texts)(value, f"{where}: {key}") for key, value in raw.items()})


def _texts(value: Any, where: str) -> tuple[str, ...]:
    items = [value] if isinstance(value, str) else value
    if not isinstance(items, list) or not items or not all(isinstance(item, str) for item in items):
        raise BadInput("needs a text or a list of texts", file=where)
    return tuple(items)


def _text(value: Any, where: str) -> str:
    return _texts(value, where)[0]


def _group(value: Any, where: str) -> str:
    if value not in INJECTION_GROUPS:
        raise BadInput(f"unknown group {value!r}", file=where, hint=f"known: {', '.join(INJECTION_GROUPS)}")
    return str(value)


def _groups(value: Any, where: str) -> tuple[tuple[str, ...], ...]:
    if isinstance(value, list) and value and all(isinstance(item, list) for item in value):
        return tuple(_texts(item, where) for item in value)
    return (_texts(value, where),)


def _flag(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise BadInput("needs true or false", file=where)
    return value


def _count(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise BadInput("needs a whole number of at least 1", file=where)
    return value


def _share(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value <= 1.0:
        raise BadInput("needs shares above 0, at most 1", file=where)
    return float(value)


def _each(reader: Callable[[Any, str], Any]) -> Callable[[Any, str], tuple[Any, ...]]:
    """Reader of one value or a list of values."""

    def read(value: Any, where: str) -> tuple[Any, ...]:
        items = value if isinstance(value, list) and value else [value]
        return tuple(reader(item, where) for item in items)

    return read


def _positive(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise BadInput("needs a positive number", file=where)
    return float(value)
