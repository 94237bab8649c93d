"""What is shipped: the wheel, the environment beside other packages, the import directions, start-up."""

import ast
import filecmp
import json
import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
LAYERS = (
    "models",
    "datasets",
    "checks",
    "estimation",
    "methods",
    "diagnosis",
    "bench",
    "reporting",
    "reproduction",
)  # each may import those to its left
ESTIMATION = (
    *(
        "numerics",
        "records",
        "observers",
        "simulation",
        "regression",
        "results",
        "run",
        "likelihood",
        "filters",
        "selection",
    ),
    *("diagnosis_only", "information", "validation", "estimates", "methods_only", "judgement", "indices"),
)  # so may these
NOT_FOR = {
    "methods": {"diagnosis_only", "judgement", "indices"},
    "diagnosis": {"methods_only", "judgement", "indices"},
    "estimation/methods_only": {"diagnosis_only"},
}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SLOW_TO_IMPORT = {"jinja2", "joblib", "matplotlib", "numba", "optuna", "pandas", "pyarrow", "sklearn", "sympy"}
SLOW_TO_IMPORT |= {"scipy.optimize"}


def run(*command: str | Path, cwd: Path) -> str:
    """Standard output of a command; its standard error is in the message where it fails."""
    done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command} ended with status {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def shipped_files(tree: Path) -> dict[str, Path]:
    """Path in the wheel -> path in the tree, of every file in the front door and in the rooms."""
    folders = {"helmbench": tree / "helmbench"} | {f"helmbench/{room}": tree / room for room in LAYERS}
    return {
        f"{inside}/{path.relative_to(folder).as_posix()}": path
        for inside, folder in folders.items()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what is packed, so that no earlier build leaks into the wheel."""
    source = tmp_path_factory.mktemp("source")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for folder in ("helmbench", *LAYERS):
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    return source


@pytest.fixture(scope="module")
def wheel(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the copy."""
    out = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", out, tree, cwd=out)
    (built,) = out.glob("*.whl")
    return built


def test_wheel_holds_the_whole_tree_and_nothing_else(tree: Path, wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = {name: archive.read(name) for name in archive.namelist() if ".dist-info/" not in name}
    expected = shipped_files(tree)
    assert {"helmbench/py.typed", "helmbench/models/vessels/mariner.yaml"} <= expected.keys()
    assert sorted(packed.keys() ^ expected.keys()) == []
    assert [name for name, path in expected.items() if packed[name] != path.read_bytes()] == []


def test_every_package_is_listed() -> None:
    folders = {"helmbench": ROOT / "helmbench"} | {f"helmbench.{room}": ROOT / room for room in LAYERS}
    found = {
        ".".join([name, *path.parent.relative_to(folder).parts])
        for name, folder in folders.items()
        for path in folder.rglob("*.py")
    }
    assert PROJECT["tool"]["setuptools"]["packages"] == sorted(found)
    assert PROJECT["tool"]["setuptools"]["package-dir"] == {f"helmbench.{room}": room for room in sorted(LAYERS)}


def test_every_room_is_checked_and_cleaned() -> None:
    """The Makefile names every room, and ty is strict with every folder of the front door."""
    (rooms,) = re.findall(r"^ROOMS := (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert tuple(rooms.split()) == LAYERS
    (strict,) = PROJECT["tool"]["ty"]["overrides"]
    front_door = {f"build/types/{path.parent.relative_to(ROOT)}" for path in ROOT.glob("helmbench/*/__init__.py")}
    assert set(strict["include"]) == {"build/types/helmbench/*.py"} | front_door


def fresh_environment(folder: Path) -> tuple[Path, Path]:
    """(interpreter, site-packages) of a new, empty virtual environment."""
    venv.create(folder, with_pip=False, symlinks=sys.platform != "win32")
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    site = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder)
    return python, Path(site.strip())


def copy_distribution(name: str, site: Path) -> dict[Path, Path]:
    """Lay a distribution of the running environment down in another one; returns copy -> original."""
    distribution = metadata.distribution(name)
    files = [f for f in distribution.files or () if ".." not in f.parts and "__pycache__" not in f.parts]
    copies = {site / str(f): Path(str(distribution.locate_file(f))) for f in files}
    for copy, original in copies.items():
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(original, copy)
    return copies


BESIDE = """
import json, sys
import datasets, helmbench
import helmbench.bench, helmbench.cli, helmbench.datasets, helmbench.models
vessels = helmbench.list_vessels()
print(json.dumps({
    "rows": datasets.Dataset.from_dict({"rudder": [0.1, 0.2]}).num_rows,
    "vessels": list(vessels),
    "files": [m.__file__ for m in (datasets, helmbench, helmbench.bench, helmbench.datasets, helmbench.models)],
}))
"""


@dataclass(frozen=True)
class Environment:
    """A fresh environment with the wheel in it, installed after Hugging Face datasets.

    copies : file of Hugging Face datasets -> its original in the running environment.
    """

    python: Path
    site: Path
    copies: dict[Path, Path]


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    folder = tmp_path_factory.mktemp("environment")
    python, site = fresh_environment(folder)
    copies = copy_distribution("datasets", site)
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", "--no-deps", wheel, cwd=folder)
    # What both depend on comes from the running environment (a .pth there, such as an editable install, stays unread).
    dependencies = {str(Path(metadata.distribution(name).locate_file(""))) for name in ("numpy", "click", "pyarrow")}
    (site / "dependencies.pth").write_text("\n".join(sorted(dependencies)), encoding="utf-8")
    return Environment(python, site, copies)


@pytest.mark.nightly
def test_wheel_beside_hugging_face_datasets(
    environment: Environment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HF_HOME", str(tmp_path / "hugging-face"))
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    seen = json.loads(run(environment.python, "-c", BESIDE, cwd=tmp_path).splitlines()[-1])

    changed = [copy for copy, original in environment.copies.items() if not filecmp.cmp(copy, original, shallow=False)]
    assert changed == []
    assert seen["rows"] == 2
    assert "mariner" in seen["vessels"]
    assert [file for file in seen["files"] if not Path(file).is_relative_to(environment.site)] == []


IN_A_CHECKOUT = """
import json
import helmbench, helmbench.datasets, helmbench.models.vessel
print(json.dumps([[m.__file__ for m in (helmbench, helmbench.datasets, helmbench.models.vessel)],
                  [str(path) for path in helmbench.models.vessel.vessel_files().values()]]))
"""


@pytest.mark.nightly
def test_python_started_in_a_checkout_takes_the_code_of_the_checkout(tree: Path, environment: Environment) -> None:
    """Its folder helmbench/ comes before the installed package, so all rooms are the checkout's, and their data."""
    modules, vessels = json.loads(run(environment.python, "-c", IN_A_CHECKOUT, cwd=tree))
    assert modules == [
        str(tree / part) for part in ("helmbench/__init__.py", "datasets/__init__.py", "models/vessel.py")
    ]
    assert sorted(vessels) == sorted(str(path) for path in (tree / "models" / "vessels").glob("*.yaml"))


def test_a_checkout_says_what_to_install_where_nothing_is() -> None:
    """`-S`: a Python without the packages that are installed for it."""
    command = [sys.executable, "-S", "-m", "helmbench", "list", "methods"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    (line,) = done.stderr.splitlines()
    assert done.returncode == 2 and line.startswith("helmbench: click is not installed; 'python -m pip install .' in")
    command = [sys.executable, "-S", "-c", "import helmbench; helmbench.simulate"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1].startswith(
        "ModuleNotFoundError: numpy is not installed; 'python -m pip install .'"
    )


def slow_modules_after(code: str, cwd: Path) -> list[str]:
    """Which of SLOW_TO_IMPORT a fresh interpreter holds after running the code."""
    report = f"import sys\n{code}\nsys.stdout.flush()\nprint('\\n' + ' '.join(sys.modules))"
    return sorted(SLOW_TO_IMPORT & set(run(sys.executable, "-c", report, cwd=cwd).splitlines()[-1].split()))


HELP = """
from helmbench.cli import main
sys.argv = ["helmbench", "--help"]
try:
    main()
except SystemExit as done:
    assert not done.code, done.code
"""


@pytest.mark.parametrize("code", [HELP, "import helmbench"], ids=["--help", "import"])
def test_start_up_imports_nothing_slow(code: str, tmp_path: Path) -> None:
    assert slow_modules_after(code, tmp_path) == []


def test_the_help_check_sees_a_slow_import(tmp_path: Path) -> None:
    assert slow_modules_after(f"import jinja2{HELP}", tmp_path) == ["jinja2"]


@cache
def imports_of(path: Path) -> list[ast.Import | ast.ImportFrom]:
    """All statements of a file that import, anywhere in it."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path)))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def absolute_imports(path: Path) -> set[str]:
    """Dotted names of all modules that a file imports absolutely, anywhere in it."""
    found = set()
    for node in imports_of(path):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif not node.level:
            found.add(str(node.module))
    return found


def relative_imports(path: Path, package: tuple[str, ...]) -> set[tuple[str, ...]]:
    """Modules and names that a file of `package` imports relatively, anywhere in it, from the top: ('models', ...)."""
    nodes = [node for node in imports_of(path) if isinstance(node, ast.ImportFrom) and node.level]
    bases = {node: (*package[: len(package) - node.level + 1], *(node.module or "").split(".")) for node in nodes}
    return {tuple(filter(None, (*base, alias.name))) for node, base in bases.items() for alias in node.names}


@pytest.mark.parametrize("room", LAYERS)
def test_imports_run_one_way(room: str) -> None:
    allowed = LAYERS[: LAYERS.index(room) + 1]
    wrong = []
    for path in sorted((ROOT / room).rglob("*.py")):
        for name in relative_imports(path, ("helmbench", *path.relative_to(ROOT).parent.parts)):
            if name[0] != "helmbench" or name[1] not in allowed:
                wrong.append(f"{path} imports {'.'.join(name)}")
    assert wrong == []


def of_estimation(folder: str) -> set[str]:
    """Folders of estimation that any file of a folder imports."""
    files = (ROOT / folder).rglob("*.py")
    imported = [relative_imports(path, ("helmbench", *path.relative_to(ROOT).parent.parts)) for path in files]
    return {name[2] for names in imported for name in names if name[1] == "estimation"}


def test_nothing_lies_loose_in_estimation() -> None:
    room = ROOT / "estimation"
    assert [path.name for path in room.glob("*.py")] == ["__init__.py"]
    assert {path.parent.name for path in room.glob("*/__init__.py")} == set(ESTIMATION)


@pytest.mark.parametrize("folder", ESTIMATION)
def test_folders_of_estimation_import_one_way(folder: str) -> None:
    assert of_estimation(f"estimation/{folder}") <= set(ESTIMATION[: ESTIMATION.index(folder) + 1])


@pytest.mark.parametrize("user", NOT_FOR)
def test_estimation_is_sorted_by_who_uses_it(user: str) -> None:
    assert of_estimation(user) & NOT_FOR[user] == set()


@pytest.mark.parametrize("room", LAYERS)
def test_rooms_import_each_other_relatively(room: str) -> None:
    own = {"helmbench", *LAYERS}
    files = (ROOT / room).rglob("*.py")
    wrong = {str(path): sorted(name for name in absolute_imports(path) if name.split(".")[0] in own) for path in files}
    assert {path: names for path, names in wrong.items() if names} == {}


def test_only_the_front_door_parses_a_command_line() -> None:
    files = [path for room in LAYERS for path in (ROOT / room).rglob("*.py")]
    assert [str(path) for path in files if "click" in absolute_imports(path)] == []


FOR_COMMANDS = {"models.errors", "models.extras", "models.files", "models.number_texts", "models.plain"}
"""What messages are made of, numbers are read by and files are written with."""


def test_commands_call_only_what_helmbench_offers() -> None:
    """Files of helmbench/cli import each other, helmbench, its api, its page, reporting and FOR_COMMANDS; others for
    types only."""
    wrong = []
    for path in sorted((ROOT / "helmbench" / "cli").glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        typed = {node for top in tree.body if isinstance(top, ast.If) for node in ast.walk(top)}
        nodes = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node not in typed]
        homes = {node.module for node in nodes if node.level == 2 and node.module is not None}
        wrong += [
            f"{path.name} imports {home}"
            for home in homes - FOR_COMMANDS
            if home.split(".")[0] not in ("api", "open", "reporting")
        ]
    assert wrong == []


OPTIONAL = ("bayes", "bench", "deep", "distributed", "identibench", "open", "pandas", "parquet", "pdf", "readers")
DISTRIBUTIONS = {"sklearn": "scikit-learn", "yaml": "pyyaml", "charset_normalizer": "charset-normalizer"}
"""Import name -> distribution, where they differ."""


def test_dependencies_are_what_is_imported() -> None:
    paths = [path for room in ("helmbench", *LAYERS) for path in (ROOT / room).rglob("*.py")]
    tops = {name.split(".")[0] for path in paths for name in absolute_imports(path)} - {"helmbench"}
    imported = {DISTRIBUTIONS.get(top, top) for top in tops - sys.stdlib_module_names}
    extras = PROJECT["project"]["optional-dependencies"]
    optional = {Requirement(text).name for extra in OPTIONAL for text in extras[extra]}
    declared = {Requirement(text).name for text in PROJECT["project"]["dependencies"]}
    assert imported - optional == declared
    assert optional - imported == {"dask", "distributed"}  # by name


def test_no_init_at_the_root() -> None:
    assert not (ROOT / "__init__.py").exists()


def test_front_door_offers_what_it_names() -> None:
    import helmbench

    assert [name for name in helmbench.__all__ if getattr(helmbench, name) is None] == []
    assert set(helmbench.__all__) <= set(dir(helmbench))
    assert helmbench.__version__ == PROJECT["project"]["version"]
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = helmbench.nothing


def closure(requirements: list[str]) -> set[str]:
    """Canonical names of installed distributions that these requirements need, and theirs in turn."""
    waiting, seen = [Requirement(text) for text in requirements], set()
    while waiting:
        need = waiting.pop()
        extras = need.extras or {""}
        key = (canonicalize_name(need.name), *sorted(extras))
        if key in seen or not (need.marker is None or need.marker.evaluate({"extra": ""})):
            continue
        seen.add(key)
        for text in metadata.distribution(need.name).requires or ():
            inner = Requirement(text)
            if inner.marker is None or any(inner.marker.evaluate({"extra": extra}) for extra in extras):
                inner.marker = None
                waiting.append(inner)
    return {key[0] for key in seen}


def test_constraints_pin_all_that_is_installed() -> None:
    lines = (ROOT / "requirements" / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert [line for line in pins if not re.fullmatch(r"[a-z0-9-]+==[0-9][0-9a-z.]*", line)] == []
    names = [line.partition("==")[0] for line in pins]
    assert names == sorted(set(names))
    project = PROJECT["project"]
    extras = project["optional-dependencies"]
    needed = closure(project["dependencies"] + extras["dev"] + extras["docs"] + extras["peers"])
    assert needed - set(names) == {project["name"]}  # the extra dev names the extras docs and peers
    assert {Requirement(text).name for text in project["optional-dependencies"]["distributed"]} <= set(names)


def test_every_pin_has_the_digests_of_its_files_and_no_address() -> None:
    text = (ROOT / "requirements" / "hashes.txt").read_text(encoding="utf-8")
    blocks = re.findall(r"^(\S+==\S+) \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", text, re.MULTILINE)
    assert "".join(f"{pin} \\\n{digests}" for pin, digests in blocks) == text  # nothing else is in the file
    lines = (ROOT / "requirements" / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert [pin for pin, _ in blocks] == [line for line in lines if not line.startswith("#")], "run `make hashes`"


def test_the_audit_says_what_it_could_not_look_up(tmp_path: Path) -> None:
    def audited(answer: str) -> tuple[int, str]:
        program = tmp_path / "pip-audit"
        program.write_text(f"#!/bin/sh\nprintf '%s' '{answer}'\n")
        program.chmod(0o755)
        command = [sys.executable, ROOT / ".ci" / "audit.py", program, "requirements/hashes.txt"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr

    bad = {"name": "one", "version": "1.0", "vulns": [{"id": "CVE-1", "fix_versions": ["1.1"]}]}
    skipped = {"name": "two", "skip_reason": "not found"}
    assert audited("")[0] == 0 and "nothing was audited" in audited("")[1]
    assert "nothing was audited" in audited(json.dumps({"dependencies": [skipped]}))[1]
    status, said = audited(json.dumps({"dependencies": [bad, skipped]}))
    assert status == 1 and "one 1.0: CVE-1, mended in 1.1" in said and "1 of 2 packages audited" in said
    assert audited(json.dumps({"dependencies": [bad | {"vulns": []}]}))[0] == 0


def test_continuous_integration_calls_the_documented_command() -> None:
    last = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()[-1]
    assert last == "make test"
    assert re.search(rf"^{last}\b", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)


def test_citation_names_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["project"]["version"]
    assert citation["license"] == PROJECT["project"]["license"]
