"""The same from the command line and in a notebook: files that stand beside a result."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

COMMANDS, NOTEBOOK = "commands.sh", "notebook.ipynb"


@dataclass(frozen=True)
class Recipe:
    """What a result was made from.

    model : an identifier, or the name of a file beside the result;  logs : names of the files;  mapping : name of the
    mapping's file;  positive_rudder : side that the user stated;  parts : `record` (its place), `name`, `from` and `to`
    in s, `role`.
    """

    kind: str
    model: str
    method: str
    logs: tuple[str, ...]
    mapping: str
    positive_rudder: str | None
    parts: tuple[Mapping[str, Any], ...]

    def names(self, role: str) -> list[str]:
        """Names of the parts of a role."""
        return [part["name"] for part in self.parts if part["role"] == role]


def write(folder: Path, recipe: Recipe) -> None:
    """Write the commands and the notebook."""
    (folder / COMMANDS).write_text(commands(recipe), "utf-8")
    (folder / NOTEBOOK).write_text(notebook(recipe), "utf-8")


def commands(recipe: Recipe) -> str:
    """A shell script: the import, and the analysis of the parts that lie in `records`."""
    imported = ["helmbench", "import", *map(_file, recipe.logs), "--map", _file(recipe.mapping), "-o", "imported.csv"]
    told = "# Put the log beside this file.  It is imported anew; the parts that were used lie in the folder records."
    lines = ["#!/bin/sh", told, _shell(imported), _shell(_analysis(recipe))]
    return "\n".join(lines) + "\n"


def _analysis(recipe: Recipe) -> list[str]:
    train, held_out = ([f"records/{name}.csv" for name in recipe.names(role)] for role in ("train", "held_out"))
    if recipe.kind == "check":
        return ["helmbench", "check", *train, *held_out, "-o", "out"]
    if recipe.kind == "identify":
        checked = ["--validate", *held_out] if held_out else []
        return ["helmbench", "identify", *train, "--model", _file(recipe.model), "--method", recipe.method, *checked,
                "-o", "out"]  # fmt: skip
    tested = ["--held-out", *held_out] if held_out else []
    model = ["--model", _file(recipe.model)] if recipe.model else []
    return ["helmbench", "diagnose", *model, "--train", *train, *tested, "-o", "out"]


def _file(name: str) -> str:
    """The name of a file as a word that no command takes for an option."""
    return f"./{name}" if name.startswith("-") else name


def _shell(words: Sequence[str]) -> str:
    return " ".join(shlex.quote(word) for word in words)


def notebook(recipe: Recipe) -> str:
    """A Jupyter notebook (format 4.5) that does the same from the log."""
    told = f"The question `{recipe.kind}` of `helmbench open`, from the log: put the log beside this file."
    cells = [_cell("markdown", told, 0)]
    cells += [_cell("code", text, place) for place, text in enumerate(code(recipe), start=1)]
    facts = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": facts, "cells": cells}, indent=1)


def _cell(kind: str, text: str, place: int) -> dict[str, Any]:
    cell: dict[str, Any] = {"cell_type": kind, "id": f"cell-{place}", "metadata": {}, "source": text}
    return cell | ({"outputs": [], "execution_count": None} if kind == "code" else {})


def code(recipe: Recipe) -> list[str]:
    """The cells of the notebook: import, parts, analysis, figure."""
    sign = f", positive_rudder={recipe.positive_rudder!r}" if recipe.positive_rudder else ""
    log = f"log = helmbench.import_log({list(recipe.logs)!r}, mapping={recipe.mapping!r}{sign})"
    parts = [
        f"    replace(log.records[{part['record']}].between({part['from']!r}, {part['to']!r}), name={part['name']!r}),"
        for role in ("train", "held_out")
        for part in recipe.parts
        if part["role"] == role
    ]
    count = len(recipe.names("train"))
    cut = ["from dataclasses import replace", "", "parts = [", *parts, "]",
           f"train, held_out = parts[:{count}], parts[{count}:]"]  # fmt: skip
    return [f"import helmbench\n\n{log}\nlog", "\n".join(cut), *_calls(recipe)]


def _calls(recipe: Recipe) -> list[str]:
    if recipe.kind == "check":
        return ["found = helmbench.check(parts)\nfound"]
    if recipe.kind == "identify":
        fitted = f"helmbench.identify(train, {recipe.model!r}, {recipe.method!r}, validate=held_out)"
        return [f"estimate = {fitted}\nfound = estimate.assess(held_out)\nfound", "found.plot()"]
    call = f"diagnose({recipe.model!r}, train, held_out)" if recipe.model else "build_model(train, held_out)"
    return [f"found = helmbench.{call}\nfound", "found.plot()"]
