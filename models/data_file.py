"""YAML and JSON data files: one loader, which can neither run code nor exhaust the machine.

YAML is read as its version 1.2 says: 1e-3 is a number, dates and 12:30 are texts, 010 is no octal number.  Refused are
tags other than those of plain data, keys that stand twice, recursion, aliases that multiply, and more than the limits.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Hashable
from functools import cache, partial
from pathlib import Path
from typing import Any

from .errors import BadInput
from .files import read_utf8
from .number_texts import number_of, whole_of

MOST_YAML_BYTES, MOST_JSON_BYTES = 96 * 2**10, 2**24
MOST_NODES, MOST_DEPTH = 200_000, 40
"""Limits of a file: keys and values (aliases counted as often as they are used), nesting."""
TOO_DEEP = f"nested deeper than {MOST_DEPTH} levels"
TOO_MANY = f"more than {MOST_NODES} keys and values, aliases counted as often as they are used"
JSON_SUFFIX = ".json"
PLAIN_TAGS = ("null", "bool", "int", "float", "str", "seq", "map", "merge")
UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")
"""Characters that no text of a data file has: they would steer a terminal, or cannot be written to a file."""
_BOOL = "yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF"
_FLOAT = r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
_SCALARS = {
    "bool": (_BOOL, "yYnNtTfFoO"),
    "int": ("0|[-+]?[1-9][0-9]*|[-+]0", "-+0123456789"),
    "float": (f"(?!0[0-9])({_FLOAT})", "-+.0123456789"),
    "merge": ("<<", "<"),
    "null": ("~|null|Null|NULL|", ["~", "n", "N", ""]),
}
"""Kind of a plain scalar -> what it looks like, and its first characters."""
_INFINITE = {".inf": math.inf, "+.inf": math.inf, "-.inf": -math.inf, ".nan": math.nan}


class _Refused(ValueError):
    """Data that is not read, with the line that it stands on where that is known."""

    def __init__(self, reason: str, row: int | None = None) -> None:
        self.row = row
        super().__init__(reason)


def load(path: str | Path) -> Any:
    """The content of a data file, JSON under that suffix, else YAML.

    Raises
    ------
    BadInput : the file cannot be read, is not of its format, or exceeds a limit; in one line with file and row.
    """
    path = Path(path)
    if path.suffix.lower() == JSON_SUFFIX:
        return json_of(read_utf8(path, MOST_JSON_BYTES), path)
    return yaml_of(read_utf8(path, MOST_YAML_BYTES), path)[0]


def json_of(data: bytes, file: object, row: int | None = None) -> Any:
    """The value of a JSON text; `row` is its line where it is one line of a larger file.  Raises as `load`."""
    try:
        content = json.loads(
            data, object_pairs_hook=_distinct, parse_int=whole_of, parse_float=number_of, parse_constant=_no_number
        )
        _check_size(content)
    except json.JSONDecodeError as error:
        raise BadInput(f"not JSON ({error.msg})", file=file, row=row or error.lineno) from None
    except UnicodeDecodeError as error:
        raise BadInput(f"not JSON ({error.reason})", file=file, row=row) from None
    except ValueError as refused:
        raise BadInput(str(refused), file=file, row=row) from None
    except RecursionError:
        raise BadInput(TOO_DEEP, file=file, row=row) from None
    return content


def yaml_of(data: bytes, file: object) -> tuple[Any, dict[Any, int]]:
    """The value of a YAML text, and the line of each key of the outermost mapping.  Raises as `load`."""
    import yaml

    try:
        loader = _yaml_loader()(data.decode())
        node = loader.get_single_node()
        if node is None:
            return None, {}
        _check_nodes(node)
        content = loader.construct_document(node)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        reason = getattr(error, "problem", None) or str(error)
        raise BadInput(f"not YAML ({reason})", file=file, row=mark.line + 1 if mark else None) from None
    except _Refused as refused:
        raise BadInput(str(refused), file=file, row=refused.row) from None
    except (KeyError, ValueError) as error:  # PyYAML's constructors, of a scalar under a tag that it does not suit
        raise BadInput(f"not YAML (a value does not suit its tag: {error})", file=file) from None
    rows = {k.value: k.start_mark.line + 1 for k, _ in node.value} if isinstance(node, yaml.MappingNode) else {}
    return content, rows


# ------------------------------------------------------------------------------------------------ JSON


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise _Refused(_twice(next(name for name in names if names.count(name) > 1)))
    return found


def _no_number(text: str) -> float:
    raise _Refused(f"{text} is not a number of JSON; write null where there is none")


def _check_size(content: Any) -> None:
    level, count = [[content]], 0
    for _ in range(MOST_DEPTH + 1):
        level = [
            child
            for value in level
            if isinstance(value, dict | list)
            for child in (value.values() if isinstance(value, dict) else value)
        ]
        count += len(level)
        if count > MOST_NODES:
            raise _Refused(TOO_MANY)
        for value in level:
            for text in value if isinstance(value, dict) else (value,):
                if isinstance(text, str):
                    _check_text(text)
        if not level:
            return
    raise _Refused(TOO_DEEP)


# ------------------------------------------------------------------------------------------------ YAML


@cache
def _yaml_loader() -> Any:
    """The loader class; made at the first use, so that nothing imports PyYAML before a file is read."""
    import yaml

    class Loader(yaml.SafeLoader):
        """Plain data in YAML 1.2, nested to a limited depth."""

        depth = 0
        yaml_implicit_resolvers: dict[Any, Any] = {}  # noqa: RUF012, PyYAML's own attribute

        def compose_node(self, parent: Any, index: Any) -> Any:
            self.depth += 1
            if self.depth > MOST_DEPTH:
                raise _Refused(TOO_DEEP, self.peek_event().start_mark.line + 1)
            node = super().compose_node(parent, index)
            self.depth -= 1
            return node

    for kind, (pattern, first) in _SCALARS.items():
        Loader.add_implicit_resolver(f"tag:yaml.org,2002:{kind}", re.compile(rf"(?:{pattern})\Z"), list(first))
    Loader.add_constructor("tag:yaml.org,2002:int", partial(_number_node, whole_of))
    Loader.add_constructor("tag:yaml.org,2002:float", partial(_number_node, _float_of))
    return Loader


def _float_of(text: str) -> float:
    return _INFINITE.get(text.lower()) or number_of(text)


def _number_node(read: Callable[[str], Any], loader: Any, node: Any) -> Any:
    try:
        return read(loader.construct_scalar(node))
    except ValueError as error:
        raise _Refused(str(error), _row(node)) from None


def _check_nodes(root: Any) -> None:
    """Refuse other tags, keys that repeat, recursion, and aliases by which the content becomes too large or deep."""
    sizes: dict[int, tuple[int, int] | None] = {}

    def size(node: Any) -> tuple[int, int]:
        """Number of nodes, and their depth."""
        if id(node) in sizes:
            known = sizes[id(node)]
            if known is None:
                raise _Refused("an alias stands within what it stands for", _row(node))
            return known
        sizes[id(node)] = None
        if node.tag.removeprefix("tag:yaml.org,2002:") not in PLAIN_TAGS:
            raise _Refused(f"not YAML (the tag {node.tag[:60]} is not one of plain data)", _row(node))
        count, depth = 1, 1
        for child in _children(node):
            more, deeper = size(child)
            count, depth = count + more, max(depth, 1 + deeper)
            if count > MOST_NODES or depth > MOST_DEPTH:
                raise _Refused(TOO_MANY if count > MOST_NODES else TOO_DEEP, _row(node))
        sizes[id(node)] = count, depth
        return count, depth

    size(root)


def _children(node: Any) -> list[Any]:
    """Nodes below a node; keys must be plain and distinct."""
    if isinstance(node.value, str):
        _check_text(node.value, _row(node))
        return []
    if not node.value or not isinstance(node.value[0], tuple):
        return list(node.value)
    seen: set[Hashable] = set()
    for key, _ in node.value:
        if not isinstance(key.value, str):
            raise _Refused("a key must be a text or a number", _row(key))
        if key.value in seen:
            raise _Refused(_twice(key.value), _row(key))
        seen.add(key.value)
    return [part for pair in node.value for part in pair]


def _check_text(text: str, row: int | None = None) -> None:
    found = UNPRINTABLE.search(text)
    if found is not None:
        raise _Refused(f"a text with the character U+{ord(found[0]):04X}", row)


def _row(node: Any) -> int:
    return node.start_mark.line + 1


def _twice(name: str) -> str:
    return f"the key {name[:60]!r} stands twice"
