"""Code that a suite file or a stored run names does not run unasked."""

import json

import pytest

import helmbench
from helmbench.bench.store import MANIFEST
from helmbench.bench.suites import foreign
from helmbench.cli import status_of

pytestmark = pytest.mark.usefixtures("in_this_process")
CODE = """
open({canary!r}, "w").close()
from helmbench.methods.ls import Ls as Base
class Mine(Base):
    name = "mine"
"""


@pytest.fixture
def trap(tmp_path):
    """A suite file that names a Python file beside it, and the file that this code would write."""
    canary = tmp_path / "canary"
    (tmp_path / "trap.py").write_text(CODE.format(canary=str(canary)))
    suite = tmp_path / "mine.yaml"
    suite.write_text(f"entries: [{{vessels: response-1, methods: ['{tmp_path}/trap.py:Mine'], noise: none}}]")
    return suite, canary


@pytest.mark.parametrize(
    "text",
    [
        "mine.py:Mine",
        "tuned:mine.py:Mine,trials=3",
        "sklearn:os.path.join",
        "tuned:sklearn:a.b",
        "tuned:ls, storage=a.journal",
    ],
)
def test_what_loads_code_or_writes_files_is_foreign(text):
    assert foreign([text, "ls", "output-error,prior=0.3", "sklearn:SVR,C=1.5"]) == [text]


def test_code_of_a_suite_file_needs_trust(trap, tmp_path, capsys):
    suite, canary = trap
    arguments = ["run", "--suite", str(suite), "-o", str(tmp_path / "out"), "--jobs", "1"]
    assert status_of(arguments) == 2
    said = capsys.readouterr().err
    assert "trap.py:Mine" in said and "--trust" in said and said.count("\n") == 1
    assert not canary.exists() and not (tmp_path / "out").exists()
    assert status_of([*arguments, "--trust"]) == 0 and canary.exists()


def test_the_question_names_the_code(trap, tmp_path):
    asked = []
    with pytest.raises(helmbench.BadInput, match="not trusted"):
        helmbench.run_suite(str(trap[0]), directory=tmp_path / "out", trust=lambda text: bool(asked.append(text)))
    assert len(asked) == 1 and "trap.py:Mine" in asked[0] and not trap[1].exists()


def test_code_of_a_stored_run_needs_trust(trap, tmp_path):
    suite, canary = trap
    suite.write_text("entries: [{vessels: response-1, methods: [ls]}]")
    out = tmp_path / "out"
    helmbench.run_suite(str(suite), directory=out, methods=["ls"], jobs=1)
    manifest = json.loads((out / MANIFEST).read_text())
    manifest["selection"]["methods"] = [f"{tmp_path}/trap.py:Mine"]
    (out / MANIFEST).write_text(json.dumps(manifest))
    with pytest.raises(helmbench.BadInput, match=r"environment.json: names code to run, which is not trusted"):
        helmbench.run_suite(directory=out, resume=True)
    assert not canary.exists()


def test_a_suite_is_no_path_without_its_suffix(tmp_path):
    (tmp_path / "s.yaml").write_text("entries: [{vessels: response-1}]")
    with pytest.raises(helmbench.BadInput, match="unknown suite"):
        helmbench.run_suite(str(tmp_path / "s"), directory=tmp_path / "out")
