"""What a base installation does without the packages of the extras, which are blocked here."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

from helmbench.models.errors import BadInput
from helmbench.models.extras import EXTRAS, extras_told

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
IMPORTED_AS = {"scikit-learn": "sklearn", "dask": "distributed"}
BLOCKED = f"""
import sys
BLOCKED = {sorted(EXTRAS)}

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in BLOCKED:
            raise ModuleNotFoundError("No module named " + repr(name), name=name)

sys.meta_path.insert(0, Blocker())
from helmbench.cli import status_of
"""
WORKS = """
import helmbench
assert set(map(callable, map(helmbench.__getattribute__, ("check", "identify", "diagnose")))) == {True}
for line in LINES:
    status = status_of(line.split())
    assert status == 0, (line, status)
assert not set(BLOCKED) & set(sys.modules)
"""
LINES = (
    "simulate response-1 --manoeuvre zigzag:20/20 --noise low --seed 1 -o one.csv",
    "simulate response-1 --manoeuvre zigzag:10/10 --noise low --seed 2 -o two.csv",
    "check one.csv two.csv",
    "identify one.csv --model nomoto-1 --method ls --validate two.csv -o model.json",
    "validate model.json two.csv -o validation",
    "import raw.csv --yes --positive-rudder starboard -o record.csv",
    "diagnose --model response-1 --train one.csv --held-out two.csv -o diagnosed",
    *("diagnose --help", "list methods", "list causes", "list suites"),
)
REFUSED = {
    "identify one.csv --model nomoto-1 --method ls-svr -o svr.json": ("sklearn", "bench"),
    "identify one.csv --model nomoto-1 --method tuned:ridge -o tuned.json": ("optuna", "bench"),
    "run --suite quick --vessel response-1 --method ls --seeds 1 -o out": ("joblib", "bench"),
    "simulate response-1 --manoeuvre zigzag:20/20 -o one.parquet": ("pyarrow", "parquet"),
    "open --no-browser": ("uvicorn", "open"),
}


def blocked(code: str, folder: Path) -> str:
    """Standard error of an interpreter without the extras that runs the code."""
    command = [sys.executable, "-c", BLOCKED + code]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder in which the base installation has done all that it must."""
    place = tmp_path_factory.mktemp("base")
    rows = [
        f"1.5.2024 10:{s // 60:02}:{s % 60:02};{10 if s % 40 < 20 else -10};{50 + s % 20};54.{s:04};8.{s:04}"
        for s in range(200)
    ]
    header = "Time;Rudder angle [deg];Heading [deg];Latitude;Longitude"
    (place / "raw.csv").write_text("\n".join([header, *rows]) + "\n")
    blocked(f"LINES = {LINES!r}{WORKS}", place)
    return place


@pytest.mark.nightly
def test_the_base_checks_imports_identifies_and_validates_without_the_extras(folder):
    assert {"one.csv", "model.json", "validation", "record.csv", "diagnosed"} <= {
        path.name for path in folder.iterdir()
    }


@pytest.mark.nightly
def test_what_needs_an_extra_says_which_in_one_line_and_writes_nothing(folder):
    before = sorted(folder.rglob("*"))
    said = blocked(f"print([status_of(line.split()) for line in {list(REFUSED)!r}], file=sys.stderr)", folder)
    *lines, statuses = said.strip().splitlines()
    assert statuses == str([2] * len(REFUSED))
    for line, (package, extra) in zip(lines, REFUSED.values(), strict=True):
        assert line.endswith(f"needs {package}: pip install 'helmbench[{extra}]'")
    assert sorted(folder.rglob("*")) == before


@pytest.mark.nightly
def test_a_package_of_the_base_that_is_missing_is_told_in_one_line(folder):
    code = (
        "BLOCKED.append('numba')\nprint(status_of(['simulate', 'response-1', '--manoeuvre', 'turn:20', '-o', 'x.csv']))"
    )
    assert blocked(code, folder).startswith("helmbench: numba is not installed; 'python -m pip install .' in")


@pytest.mark.nightly
def test_data_frames_say_in_python_which_extra_they_need(folder):
    code = """
import helmbench
record = helmbench.read_record("one.csv")
for table in (record.to_dataframe, lambda: helmbench.Record.from_dataframe(None)):
    try:
        table()
    except helmbench.BadInput as error:
        print(error, file=sys.stderr)
"""
    assert blocked(code, folder).splitlines() == ["this needs pandas: pip install 'helmbench[pandas]'"] * 2


def test_every_package_of_an_extra_that_is_imported_is_known():
    """`EXTRAS` is what pyproject.toml says; readers have their own messages, and the rest is for development."""
    extras = PROJECT["optional-dependencies"]
    known = {(IMPORTED_AS.get(Requirement(text).name, Requirement(text).name), extra)
             for extra in set(EXTRAS.values()) for text in extras[extra]}  # fmt: skip
    assert set(EXTRAS.items()) <= known
    assert {name for name, _ in known} == set(EXTRAS)


def test_a_module_that_no_extra_brings_is_no_matter_of_extras():
    with pytest.raises(ModuleNotFoundError, match="no_such_module"), extras_told():
        import no_such_module  # noqa: F401
    with pytest.raises(BadInput, match=r"needs joblib: pip install 'helmbench\[bench\]'"), extras_told():
        raise ModuleNotFoundError(name="joblib.externals")


def test_the_conda_recipe_asks_for_the_same_packages():
    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    asked = [text.replace(" ", "").replace("matplotlib-base", "matplotlib") for text in recipe["requirements"]["run"]]
    assert asked == [f"python{PROJECT['requires-python']}", *PROJECT["dependencies"]]
    assert recipe["context"]["version"] == PROJECT["version"]
