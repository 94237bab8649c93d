"""Random changes of a valid file: of its bytes, and of the data that it holds."""

import json
import random
from typing import Any

import yaml

VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 7, 1e-9, 1e12, 1e300, -1e300, 10**17, 10**30, 10**400, "", " ", "port", "Starboard",
    "nan",
    "inf", "1e3", "2026-01-31", "x" * 5000, "..", "/", "\x00", "\x1b[31m", "\u202e", "=1+1", "deg", "rad", "s",
    "trap.py:Mine",
    "trap", "../trap", "nomoto-1", "mmg", "abkowitz+environment", "nomoto-1+rudder_offset", "sklearn:os.system",
    "tuned:ls,storage=sqlite:///x", "ls,storage=x.journal", "zigzag:1e300/1e300", "steps:30deg/1e-9s",
    "sine:1deg/1e-300s",
    [], {}, [[]], [None], [1, 2, 3], {"value": 2, "unit": "deg"}, {"value": None, "unit": "s"}, ["a"] * 500,
)  # fmt: skip
KEYS = (
    "family",
    "core",
    "positive_ruder",
    "value",
    "unit",
    "<<",
    "",
    "__class__",
    "constant",
    "extra",
    "schema",
    "seeds",
)
TOKENS = (
    b"\x00", b"\xff", b"\xef\xbb\xbf", b"\r", b"\n\n", b"\t", b",", b";", b'"', b"'", b"{", b"}", b"[", b"]",
    b": ", b"- ", b"? ",
    b"&a ", b"*a", b"<<: *a\n", b"!!binary x", b"!!python/object/apply:os.system ['touch canary']", b"!!set {a}",
    b"!!omap [a: 1]",
    b"!!timestamp 2020-01-01", b"!!int 1:30", b"!!float 1:30.5", b"--- ", b"... ", b"%YAML 9.9\n", b"|", b">-",
    b"#", b"@", b"`", b"1e999",
    b".nan", b"-.inf", b"NaN", b"Infinity", b"9" * 5000, b"[" * 3000, b"{a: " * 500, b"- " * 3000, b"\\ud800",
    b"\\u001b", b"nan", b"inf",
    b"&a [*a, *a]", b"1,5", b"=cmd()", b"\xc3\x28", b"x" * 20000, b"\xe2\x80\xae",
)  # fmt: skip


def mutated(seed: bytes, other: bytes, rng: random.Random) -> bytes:
    """A changed copy of a file; `other` is one that parts may be taken from."""
    data = seed
    for _ in range(1 + rng.randrange(4)):
        data = _data_changed(data, rng) if rng.random() < 0.5 else _bytes_changed(data, other, rng)
    return data


def _bytes_changed(data: bytes, other: bytes, rng: random.Random) -> bytes:
    at, to = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    kind = rng.randrange(8)
    if kind == 0:
        return data[:at] + rng.choice(TOKENS) + data[at:]
    if kind == 1:
        return data[:at] + data[min(to, at + 40) :]
    if kind == 2:
        return data[:at] + data[at : at + 60] * rng.choice((2, 3, 200)) + data[at:]
    if kind == 3 and data:
        return data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
    if kind == 4:
        return data[:at]
    if kind == 5:
        return data[:at] + other[min(at, len(other)) : to]
    if kind == 6:
        lines = data.split(b"\n")
        rng.shuffle(lines)
        return b"\n".join(lines)
    return data[:at] + rng.choice(TOKENS) + data[to:]


def _data_changed(data: bytes, rng: random.Random) -> bytes:
    """One value, key or entry of the data changed, written as JSON (which YAML reads too); bytes of other files."""
    lines = data.split(b"\n")
    place = rng.randrange(len(lines))
    try:
        if len(data) > 20_000:
            return data
        content = json.loads(data) if data.lstrip().startswith(b"{") else yaml.safe_load(data)
        if not isinstance(content, dict | list) or not content:
            return data
        return _dumped(_changed(content, rng))
    except (ValueError, LookupError, yaml.YAMLError, RecursionError, TypeError, AttributeError, ArithmeticError):
        pass
    try:  # a line of a journal
        lines[place] = _dumped(_changed(json.loads(lines[place]), rng))
    except (ValueError, TypeError, RecursionError):
        cells = lines[place].split(b",")
        cells[rng.randrange(len(cells))] = _dumped(rng.choice(VALUES))[:300]
        lines[place] = b",".join(cells)
    return b"\n".join(lines)


def _dumped(value: Any) -> bytes:
    return json.dumps(value, default=str).encode()


def _changed(value: Any, rng: random.Random, depth: int = 0) -> Any:
    if isinstance(value, dict) and value and rng.random() < 0.9:
        key = rng.choice(list(value))
        kind = rng.randrange(6) if depth or len(value) > 1 else 0
        if kind == 1:
            return {k: v for k, v in value.items() if k != key}
        if kind == 2:
            return {**value, rng.choice(KEYS): rng.choice(VALUES)}
        if kind == 3:
            return {(str(k)[:-1] if k == key else k): v for k, v in value.items()}
        return {**value, key: _changed(value[key], rng, depth + 1)}
    if isinstance(value, list) and value and rng.random() < 0.9:
        place = rng.randrange(len(value))
        return [*value[:place], _changed(value[place], rng, depth + 1), *value[place + 1 :]]
    return rng.choice(VALUES)
