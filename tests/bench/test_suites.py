"""Suite files: what is read, and that everything else is refused with a place."""

import json

import pytest

import helmbench
from helmbench.bench.kinds.identification.suite import RunsEntry
from helmbench.bench.store import MANIFEST
from helmbench.bench.suites import foreign, load_suite, suite_names
from helmbench.cli import status_of
from helmbench.models.errors import BadInput


def test_the_suites_are_there():
    themes = [
        "channels",
        "disturbances",
        "excitation",
        "minutes",
        "mismatch",
        "noise",
        "outliers",
        "sampling",
        "tuners",
    ]
    diagnosis = ["diagnosis", "exam", "false-discovery", "imperfect", "input-faults", "one-bug", "regimes", "unknown"]
    assert suite_names() == sorted(
        ["default", "generalise", "measured", "quick", "response-models", *diagnosis, *themes]
    )
    for name in suite_names():
        suite = load_suite(name)
        assert suite.name == name and suite.title and suite.entries


def test_a_file_of_the_user_is_read(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        "title: mine\n"
        "entries:\n"
        "  - vessels: mariner\n"
        "    methods: [ls, 'rls,variant=as_printed']\n"
        "    held_out: [[turn:35], [zigzag:10/10]]\n"
        "    noise: [none, low]\n"
        "    seeds: 3\n"
        "    train: [zigzag:20/20, turn:35]\n"
        "    thinning: [1, 8]\n"
        "    length: 0.5\n"
        "    dt_s: 1\n"
    )
    suite = load_suite(str(path))
    assert (suite.name, suite.title) == ("mine", "mine")
    assert suite.entries == (
        RunsEntry(
            vessels=("mariner",),
            methods=("ls", "rls,variant=as_printed"),
            held_out=(("turn:35",), ("zigzag:10/10",)),
            train=(("zigzag:20/20", "turn:35"),),
            noise=("none", "low"),
            thinning=(1, 8),
            length=(0.5,),
            seeds=3,
            dt_s=1.0,
        ),
    )


def test_the_digest_changes_with_the_content(tmp_path):
    path = tmp_path / "mine.yaml"
    digests = set()
    for noise in ("low", "high"):
        path.write_text(f"entries: [{{noise: {noise}}}]")
        digests.add(load_suite(str(path)).digest)
    assert len(digests) == 2


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("entries: [", "not YAML"),
        ("- 1", "is not a suite"),
        ("title: x", "has no list of entries"),
        ("entries: [1]", "entry 1: is not a mapping"),
        ("entries: [{noise: low}, {nois: low}]", "entry 2: unknown key 'nois'"),
        ("entries: [{noise: 3}]", "entry 1: noise: needs a text"),
        ("entries: [{noise: []}]", "entry 1: noise: needs a text"),
        ("entries: [{seeds: 0}]", "entry 1: seeds: needs a whole number"),
        ("entries: [{thinning: [1, 0]}]", "entry 1: thinning: needs a whole number"),
        ("entries: [{thinning: []}]", "entry 1: thinning: needs a whole number"),
        ("entries: [{length: 1.5}]", "entry 1: length: needs shares above 0"),
        ("entries: [{seeds: true}]", "entry 1: seeds: needs a whole number"),
        ("entries: [{dt_s: -1}]", "entry 1: dt_s: needs a positive number"),
        ("entries: [{euler: maybe}]", "entry 1: euler: needs true or false"),
        ("entries: [{dataset: kvlcc2-hsva}]", "entry 1: a dataset entry needs train and held_out"),
    ],
)
def test_a_broken_file_is_refused_with_the_place(tmp_path, text, complaint):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        load_suite(str(path))
    assert complaint in str(caught.value) and "mine.yaml" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "hint"), [("quik", r"did you mean quick\?"), ("no/such/suite.yaml", "default, .*quick")]
)
def test_an_unknown_suite_names_the_nearest_or_all(name, hint):
    with pytest.raises(BadInput, match=hint):
        load_suite(name)


# ---- Code that a suite file or a stored run names does not run unasked.

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
