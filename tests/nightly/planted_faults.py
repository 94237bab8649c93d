"""Plants faults in the source one at a time, and counts which of them `make test` and `make test-all` find.

    .venv/bin/python -m tests.nightly.planted_faults --count 40 --seed 1 --jobs 2

Works on clones of the last commit in build/planted_faults, never on the checkout itself.  All tests are run once
without a fault, to see which execute the function of each fault: only these are run with it, the nearest first.
Where that cannot be seen (a line outside of functions, a function that keeps its results or that Numba compiles) all
tests are run.  Of a fault that the tests of `make test` find the nightly ones are not run: `make test-all` holds
both.
"""

import argparse
import ast
import os
import random
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = (
    *("models", "datasets", "checks", "estimation", "methods", "diagnosis", "bench", "reporting", "reproduction"),
    "helmbench",
)
MARKED = {"property", "cached_property", "staticmethod", "classmethod", "contextmanager", "typed"}
"""Decorators of functions that a mark can be put into."""
MARKS = """
import os
seen = set()
def at(number):
    test = os.environ.get("PYTEST_CURRENT_TEST")
    if test and (number, test) not in seen:
        seen.add((number, test))
        with open({folder!r} + f"/{{number}}", "a", encoding="utf-8") as file:
            file.write(test + chr(10))
"""
"""The module that a mark calls: it notes the test that executes the marked function."""
LIMIT_S = 3600.0
"""A run that takes longer is stopped: the fault is found, as it makes the program hang."""
SWAPPED = {
    **{ast.Lt: ">", ast.LtE: ">", ast.Gt: "<", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "=="},
    **{ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in"},
}
CONVERTED = {"deg2rad": "rad2deg", "rad2deg": "deg2rad", "radians": "degrees", "degrees": "radians"}
UNITS = {1852.0, 3600.0, 60.0, 0.514444, 1.852}


@dataclass(frozen=True)
class SourceFault:
    """Characters `start` to `end` of a file are replaced by `text`."""

    file: str
    kind: str
    line: int
    start: int
    end: int
    text: str

    def planted(self, source: str) -> str:
        """The source (a file's text) with the fault in it."""
        return source[: self.start] + self.text + source[self.end :]


class SyntaxPlaces:
    """A file's text and where its syntax nodes stand."""

    def __init__(self, file: str, text: str) -> None:
        self.file, self.text, self.tree = file, text, ast.parse(text)
        self.rows = [0]
        for line in text.splitlines(keepends=True):
            self.rows.append(self.rows[-1] + len(line))
        self.lines = text.splitlines()
        self.parents = {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}

    def at(self, line: int, column: int) -> int:
        """Place of a node's line (from 1) and column (bytes of UTF-8) in the text."""
        return self.rows[line - 1] + len(self.lines[line - 1].encode()[:column].decode())

    def span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        """First and last place of an expression or a statement."""
        assert node.end_lineno is not None and node.end_col_offset is not None
        return self.at(node.lineno, node.col_offset), self.at(node.end_lineno, node.end_col_offset)

    def fault(
        self, kind: str, node: ast.expr, text: str, start: int | None = None, end: int | None = None
    ) -> SourceFault:
        """A fault that replaces the expression, or a part of it."""
        first, last = self.span(node)
        return SourceFault(
            self.file, kind, node.lineno, first if start is None else start, last if end is None else end, text
        )

    def between(self, kind: str, left: ast.expr, right: ast.expr, old: str, new: str) -> Iterator[SourceFault]:
        """The operator between two expressions is replaced."""
        start, end = self.span(left)[1], self.span(right)[0]
        gap = re.search(rf"(?<![\w=<>!]){re.escape(old)}(?![\w=<>])", self.text[start:end])
        if gap:
            yield self.fault(kind, left, new, start + gap.start(), start + gap.end())

    def faults(self) -> Iterator[SourceFault]:
        """Every fault that can be planted in this file."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.BinOp):
                yield from self._of_operation(node)
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
                if not isinstance(node.operand, ast.Constant):
                    yield self.fault("sign", node, "+", None, self.span(node)[0] + 1)
            elif isinstance(node, ast.Subscript):
                yield from self._of_index(node)
            elif isinstance(node, ast.Compare) and len(node.ops) == 1:
                yield from self._of_comparison(node)
            elif isinstance(node, ast.Attribute) and node.attr in CONVERTED:
                start = self.span(node)[1] - len(node.attr)
                yield self.fault("unit", node, CONVERTED[node.attr], start)
            elif isinstance(node, ast.Constant) and type(node.value) in (int, float) and float(node.value) in UNITS:
                yield self.fault("unit", node, "1.0")
            elif isinstance(node, ast.If) and [type(line) for line in node.body + node.orelse] == [ast.Raise]:
                yield self.fault("check", node.test, "False")

    def _of_operation(self, node: ast.BinOp) -> Iterator[SourceFault]:
        texts = (ast.JoinedStr, ast.List, ast.Tuple, ast.Dict, ast.Set)
        if any(isinstance(n, texts) or isinstance(getattr(n, "value", None), str) for n in (node.left, node.right)):
            return
        if isinstance(node.op, ast.Add):
            yield from self.between("sign", node.left, node.right, "+", "-")
        elif isinstance(node.op, ast.Sub):
            yield from self.between("sign", node.left, node.right, "-", "+")
        elif isinstance(node.op, (ast.Mult, ast.Div)):
            for side in (node.left, node.right):
                if isinstance(side, ast.Constant) and isinstance(side.value, (int, float)) and side.value:
                    yield self.fault("factor", side, repr(2 * side.value))

    def _of_index(self, node: ast.Subscript) -> Iterator[SourceFault]:
        index = node.slice
        negative = isinstance(index, ast.UnaryOp) and isinstance(index.operand, ast.Constant)
        if isinstance(index, ast.Constant) and type(index.value) is int:
            yield self.fault("index", index, str(index.value + 1 if index.value < 1 else index.value - 1))
        elif negative and isinstance(index.op, ast.USub):
            yield self.fault("index", index, "0")

    def _of_comparison(self, node: ast.Compare) -> Iterator[SourceFault]:
        names = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
        names |= {ast.Is: "is", ast.IsNot: "is not", ast.In: "in", ast.NotIn: "not in"}
        kind = type(node.ops[0])
        yield from self.between("comparison", node.left, node.comparators[0], names[kind], SWAPPED[kind])


def in_annotation(source: SyntaxPlaces, fault: SourceFault) -> bool:
    """Whether a fault would stand in the type of an argument or in a condition for type checkers."""
    for node in ast.walk(source.tree):
        hints = (node.annotation,) if isinstance(node, (ast.arg, ast.AnnAssign)) else ()
        hints += (node.returns,) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) else ()
        for hint in filter(None, hints):
            start, end = source.span(hint)
            if start <= fault.start < end:
                return True
    return False


def drawn(count: int, seed: int) -> list[SourceFault]:
    """Faults, spread over rooms and kinds in turn: each from another file."""
    rng = random.Random(seed)
    chosen: list[SourceFault] = []
    kinds = ["sign", "factor", "index", "comparison", "unit", "check"]
    files = {room: sorted(p for p in (ROOT / room).rglob("*.py")) for room in ROOMS}
    while len(chosen) < count:
        room, kind = ROOMS[len(chosen) % len(ROOMS)], rng.choice(kinds)
        path = rng.choice(files[room])
        source = SyntaxPlaces(str(path.relative_to(ROOT)), path.read_text("utf-8"))
        sites = [f for f in source.faults() if f.kind == kind and not in_annotation(source, f)]
        if sites and source.file not in {f.file for f in chosen}:
            chosen.append(rng.choice(sites))
    return chosen


def imports(path: Path, root: Path) -> set[str]:
    """Files of the checkout that a file imports, by path relative to the root."""
    package = list(path.relative_to(root).parent.parts)
    names: set[tuple[str, ...]] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            base = (*above, *(node.module or "").split(".")) if node.module else tuple(above)
            names |= {base, *((*base, alias.name) for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {tuple(alias.name.split(".")) for alias in node.names}
    found = set()
    for name in names:
        inner = name[1:] if name[:1] == ("helmbench",) and name[1:2] and name[1] in ROOMS else name
        for file in (root.joinpath(*inner).with_suffix(".py") if inner else root, root.joinpath(*inner, "__init__.py")):
            if file.is_file():
                found.add(str(file.relative_to(root)))
    return found


def distances(file: str) -> dict[str, int]:
    """Test file -> steps of imports between it and a file of the source."""
    every = [p for top in (*ROOMS, "tests") for p in (ROOT / top).rglob("*.py")]
    importers: dict[str, set[str]] = {}
    for path in every:
        for imported in imports(path, ROOT):
            importers.setdefault(imported, set()).add(str(path.relative_to(ROOT)))
    steps, edge = {file: 0}, [file]
    while edge:
        edge = [
            new
            for old in edge
            for new in importers.get(old, ())
            if new not in steps and not steps.update({new: steps[old] + 1})
        ]
    return {name: n for name, n in steps.items() if re.search(r"(^|/)test_\w+\.py$", name)}


def marked(fault: SourceFault, number: int, source: str) -> str | None:
    """The source with a mark in the function of the fault; None where none can be put."""
    place = SyntaxPlaces(fault.file, source)
    functions = [
        node
        for node in ast.walk(place.tree)
        if isinstance(node, ast.FunctionDef)
        and place.at(node.body[0].lineno, node.body[0].col_offset) <= fault.start < place.span(node)[1]
    ]
    if not functions:
        return None
    named = {ast.unparse(d).split("(")[0].split(".")[-1] for f in functions for d in f.decorator_list}
    if named - MARKED:
        return None
    body = functions[-1].body
    first = next((n for n in body if not (isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))), body[-1])
    decorators = getattr(first, "decorator_list", [])
    line, column = (
        (decorators[0].lineno, decorators[0].col_offset - 1) if decorators else (first.lineno, first.col_offset)
    )
    start = place.at(line, column)
    gap = "\n" + " " * column if place.lines[line - 1][:column].isspace() else "; "
    return f'{source[:start]}__import__("fault_marks").at({number}){gap}{source[start:]}'


def executing(faults: list[SourceFault], folder: Path) -> dict[SourceFault, list[str] | None]:
    """The tests that execute the function of each fault: None where that cannot be told, so that all are run.

    A result of a fixture is used by other tests: where a fixture executes the function, the whole file counts.
    """
    notes = folder / "build" / "marks"
    notes.mkdir(parents=True)
    packages = next((folder / ".venv" / "lib").glob("python3*/site-packages"))
    (packages / "fault_marks.py").write_text(MARKS.format(folder=str(notes)), "utf-8")
    texts = {fault: (folder / fault.file).read_text("utf-8") for fault in faults}
    new = {fault: marked(fault, number, texts[fault]) for number, fault in enumerate(faults)}
    for fault, text in new.items():
        if text is not None:
            (folder / fault.file).write_text(text, "utf-8")
    done = run(folder, ["-n", "2", "--dist", "worksteal", "tests", "tests/nightly"])
    print(done.stdout.splitlines()[-1], flush=True)
    for fault, text in texts.items():
        (folder / fault.file).write_text(text, "utf-8")
    return {fault: tests_of(notes / str(number)) or None for number, fault in enumerate(faults)}


def tests_of(notes: Path) -> list[str]:
    """The tests (files, or one test of a file) that a mark has noted."""
    lines = notes.read_text("utf-8").splitlines() if notes.exists() else []
    phases = [re.fullmatch(r"(.*?)(?:@\S+)? \((\w+)\)", line) for line in lines]
    whole = {m[1].split("::")[0] for m in phases if m and m[2] == "setup"}
    single = {m[1] for m in phases if m and m[1].split("::")[0] not in whole}
    shared = [name for file in whole for name in users(file)]
    return sorted({*whole, *shared}) + sorted(n for n in single if n.split("::")[0] not in shared)


def users(file: str) -> list[str]:
    """Other test files that use a fixture of the whole run that this file uses, too."""
    every = re.findall(r"@pytest\.fixture.*\ndef (\w+)", (ROOT / "tests" / "shared.py").read_text("utf-8"))
    used = [name for name in every if re.search(rf"\b{name}\b", (ROOT / file).read_text("utf-8"))]
    return [
        other
        for other in test_files()
        if any(re.search(rf"def test\w*\([^)]*\b{name}\b", (ROOT / other).read_text("utf-8")) for name in used)
    ]


def test_files() -> list[str]:
    """Every file of tests that the two commands run."""
    every = sorted(str(p.relative_to(ROOT)) for p in (ROOT / "tests").rglob("test_*.py"))
    return [name for name in every if not name.startswith("tests/timing/")]


def order(file: str, tests: list[str]) -> list[str]:
    """The tests, those nearest to the fault first."""
    steps = distances(file)
    steps |= {name: 0 for name in test_files() if name.startswith(f"tests/{Path(file).parent}/")}
    return sorted(tests, key=lambda name: (steps.get(name.split("::")[0], 99), name))


def run(folder: Path, arguments: list[str]) -> subprocess.CompletedProcess[str]:
    """Pytest in a clone; raises TimeoutExpired."""
    command = [".venv/bin/pytest", "-q", "-p", "no:cacheprovider", *arguments]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "NUMBA_CACHE_DIR": str(folder / "build" / "numba")}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LIMIT_S, check=False
    )


def failing(folder: Path, marker: str, tests: list[str]) -> str:
    """What some tests say of the code in a folder: the first failing one, or nothing."""
    if not tests:
        return ""
    listed = folder / "build" / "tests.txt"
    listed.write_text("\n".join(tests), "utf-8")
    try:
        done = run(folder, ["-x", "-m", marker, f"@{listed}"])
        if done.returncode == pytest.ExitCode.USAGE_ERROR:  # a name that pytest does not find again
            done = run(folder, ["-x", "-m", marker, *dict.fromkeys(name.split("::")[0] for name in tests)])
    except subprocess.TimeoutExpired:
        return f"no end in {LIMIT_S:.0f} s"
    if done.returncode in (0, 5):
        return ""
    first = re.search(r"^(?:FAILED|ERROR) (.*)$", done.stdout, re.MULTILINE)
    return first.group(1) if first else done.stdout[-200:] + done.stderr[-200:]


def judged(fault: SourceFault, tests: list[str] | None, folder: Path) -> tuple[str, str]:
    """Which command finds a fault (`test`, `test-all`, `none`), and by which test."""
    path = folder / fault.file
    source = path.read_text("utf-8")
    path.write_text(fault.planted(source), "utf-8")
    ranked = order(fault.file, test_files() if tests is None else tests)
    try:
        for command, marker in (("test", "not nightly"), ("test-all", "nightly")):
            if said := failing(folder, marker, ranked):
                return command, said
        return "none", ""
    finally:
        path.write_text(source, "utf-8")


def clone(number: int) -> Path:
    """A fresh clone of the last commit with an environment of its own."""
    folder = ROOT / "build" / "planted_faults" / str(number)
    subprocess.run(["rm", "-rf", str(folder)], check=True)
    subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
    subprocess.run(["make", "-s", "env", "browser", "compiler"], cwd=folder, check=True, capture_output=True)
    return folder


def main() -> None:
    """Draw, plant, judge and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(2**31))
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    faults = drawn(asked.count, asked.seed)
    print(f"{len(faults)} faults, seed {asked.seed}", flush=True)
    folders: SimpleQueue[Path] = SimpleQueue()
    clones = [clone(number) for number in range(asked.jobs)]
    tests = executing(faults, clones[0])
    for folder in clones:
        folders.put(folder)

    def one(fault: SourceFault) -> str:
        folder = folders.get()
        try:
            finder, said = judged(fault, tests[fault], folder)
        finally:
            folders.put(folder)
        print(f"{finder:9} {fault.kind:10} {fault.file}:{fault.line} -> {fault.text!r}  {said}", flush=True)
        return finder

    with ThreadPoolExecutor(asked.jobs) as pool:
        counts = Counter(pool.map(one, faults))
    every = counts["test"] + counts["test-all"]
    print(
        f"make test finds {counts['test']} of the {every} faults that make test-all finds; {counts['none']} stay hidden"
    )


if __name__ == "__main__":
    main()
