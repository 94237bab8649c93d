"""Files beside a result of the page: names of logs and parts are words of its commands and texts of its notebook."""

import ast
import json
import shlex
import subprocess

import pytest

from helmbench.open.projects import safe_name
from helmbench.open.recipes import COMMANDS, NOTEBOOK, Recipe, write

NAMES = (
    *("-o.csv", "--force", "a'; id; '.csv", '$(id)".csv', "`id`", "a\nimport os\n.csv", "'); import os; ('", "%run x"),
    *("\\", "a\\'", "{x}", "\u202ea", "!id", "a\u2028b", "#", "~/.csv", "*", "x" * 5000, "../../x.csv", "日本.csv"),
)


def made(folder, kind, name):
    """The words of every command, and the trees of the notebook's cells."""
    part = {"record": 0, "name": name, "from": 0.0, "to": 1.0, "role": "train"}
    held_out = part | {"role": "held_out"}
    write(folder, Recipe(kind, name, "ls", (name,), f"{name}.yaml", "port", (part, held_out)))
    script = folder / COMMANDS
    assert subprocess.run(["sh", "-n", str(script)], capture_output=True, check=False).returncode == 0
    words = shlex.split(script.read_text("utf-8"), comments=True)
    cells = json.loads((folder / NOTEBOOK).read_text("utf-8"))["cells"]
    return words, [ast.parse(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.parametrize("kind", ["check", "identify", "diagnose"])
def test_no_name_is_a_command_or_an_option(kind, tmp_path):
    """The words are those of a harmless name but for the name; the cells have the same tree but for their texts."""
    words, trees = made(tmp_path, kind, "harmless")
    for name in (safe_name(f"{text}q7") for text in NAMES):
        own, cells = made(tmp_path, kind, name)
        assert [word.replace(name, "harmless").removeprefix("./") for word in own] == words
        assert not [word for word in own if word.startswith("-") and name in word]
        assert [shape(tree) for tree in cells] == [shape(tree) for tree in trees]


def shape(tree):
    """The tree with every text of it left out."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = ""
    return ast.dump(tree)
