"""An exam is sealed, takes answers of any make, and scores them by its key."""

import json
import re
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import helmbench
from helmbench.bench.exam import folder as exams
from helmbench.bench.exam.exam_file import group_list
from helmbench.bench.exam.key import WorldKey
from helmbench.bench.exam.motion import error, errors, opening, predicted
from helmbench.bench.exam.scores import ALL, EffectSizes, WorldScore, naming, score, summary
from helmbench.bench.exam.submission import WorldAnswer, read_submission, stated
from helmbench.bench.exam.worlds import HIDDEN, KINDS, MOST, SPREAD, is_hidden, kind_of_case, sister
from helmbench.bench.faults import FaultCase, inject
from helmbench.bench.faults.ships import ship, sister_numbers
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.bases import bug_of, numbers_of, with_numbers
from helmbench.bench.kinds.diagnosis.execute import right_names
from helmbench.bench.kinds.diagnosis.plan import CaseSpec, plan
from helmbench.bench.suites import load_suite
from helmbench.cli import status_of
from helmbench.datasets import randomness
from helmbench.datasets.record import Record
from helmbench.diagnosis.innovations.as_model import FIRST_PART
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.reporting.exam import folder_texts

from ...seeds import seed_of
from .entrants import perfect, submission

COUNT = 7
LONG = 13
"""Digits of a number that no other number in the folder has by chance."""


def kinds_of(seed, ships):
    """Kinds of world that two ships have under a seed: a pair of effects falls to neither of them at times."""
    specs = plan(load_suite("exam"), RunSelection("exam", ("innovations",), ships, seed=seed))
    return {kind_of_case(spec) for spec in specs if is_hidden(spec) and spec.method != "oracle"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(exam, its key, the key's file)."""
    place = tmp_path_factory.mktemp("exam")
    ships = ("kvlcc2-l7", "response-1")
    seed = next(seed for seed in count(seed_of("exam")) if kinds_of(seed, ships) == set(KINDS))
    exam = exams.make(place / "exam", place / "key.json", folder_texts, count=COUNT, seed=seed, vessels=ships)
    return exam, exam.key(place / "key.json"), place / "key.json"


def test_an_exam_has_every_kind_of_world_and_draws_them_anew(made):
    exam, key, _ = made
    assert {world.kind for world in key.worlds.values()} == set(KINDS) and len(exam.worlds) == COUNT
    assert randomness.drawn_seed() != randomness.drawn_seed()


def numbers_in(value):
    """Every number in nested data."""
    if isinstance(value, dict):
        return [x for one in value.values() for x in numbers_in(one)]
    if isinstance(value, list | tuple):
        return [x for one in value for x in numbers_in(one)]
    return [value] if isinstance(value, int | float) and not isinstance(value, bool) else []


def long_numbers(texts):
    """First digits of the numbers that have so many."""
    digits = (text.partition("e")[0].replace(".", "").lstrip("-0") for text in texts)
    return {text[:LONG] for text in digits if len(text) >= LONG}


def test_the_folder_holds_no_answer(made):
    """No number of the truth, no cause beyond the public list, no kind of world, and no motion after the opening."""
    exam, key, _ = made
    texts = {p.relative_to(exam.folder).as_posix(): p.read_text("utf-8") for p in exam.folder.rglob("*.*")}
    public = {exams.CAUSES, exams.SUBMISSION_SCHEMA, "README.md", "equations.md"}
    assert set(texts) == public | {exams.MANIFEST} | set(key.files)
    secret = [
        x for w in key.worlds.values() for x in numbers_in([w.case.seed, w.factors, w.effects, [*map(vars, w.regimes)]])
    ]
    secret += [key.seed, *numbers_in([[w.rmse_base, w.rmse_best] for w in key.worlds.values()])]
    digits = long_numbers(map(repr, secret))
    assert len(digits) > COUNT
    assert not digits & long_numbers(re.findall(r"[\d.]+", "\n".join(texts.values())))
    manifest = json.loads(texts[exams.MANIFEST])
    for name, world in manifest["worlds"].items():
        assert world.pop("groups") == group_list(exam.model(name)), "groups tell the family only"
    tables = {name: text.partition("\n") for name, text in texts.items() if name.endswith(".csv")}
    assert all(set(body) <= set("0123456789.,e+-\n") for _, _, body in tables.values())
    told = [json.dumps(manifest), *(head for head, _, _ in tables.values())]
    told += [text for name, text in texts.items() if "/" in name and name not in tables]
    for word in (*exam.causes, *KINDS, "one-bug", "unstated", "off-5", "off-10", "injected"):
        assert not any(re.search(rf"\b{word}\b", text) for text in told), word


def test_held_out_records_hold_no_motion_after_the_opening(made):
    exam, key, _ = made
    for name, world in key.worlds.items():
        for record in exam.records(name, exam.worlds[name].held_out):
            kept = world.held_out[record.name]
            for channel in kept.measured:
                values = record.column(channel)
                assert np.isfinite(values[: kept.start]).any() and np.isnan(values[kept.start :]).all()
            assert np.isfinite(record.rudder()).all()
            assert exam.worlds[name].opening_s[record.name] == record.time_s[kept.start - 1]


def test_the_same_files_and_columns_for_every_world_of_a_ship(made):
    exam, key, _ = made
    shapes = {}
    for name, world in key.worlds.items():
        records = [p.relative_to(exam.folder / name).as_posix() for p in sorted((exam.folder / name).iterdir())]
        columns = (exam.folder / name / "train-1.csv").read_text("utf-8").partition("\n")[0]
        shapes.setdefault(world.case.vessel, set()).add((*records, columns))
    assert all(len(own) == 1 for own in shapes.values())


def test_a_perfect_submission_has_full_scores(made, tmp_path):
    exam, key, file = made
    perfect(exam, key, tmp_path / "perfect")
    scores, rows = score(exam.folder, file, [tmp_path / "perfect"])
    assert all(row.alone for row in rows), [(row.kind, row.outcome, row.named) for row in rows if not row.alone]
    whole = scores[0]
    assert (whole.kind, whole.alone, whole.right_share, whole.false_alarms, whole.coverage) == (ALL, 1.0, 1.0, 0.0, 1.0)
    assert whole.sizes > 0 and whole.wrong_size < 1e-12 and whole.interval < 1e-12 and whole.predicted == 1.0
    assert whole.to_best == pytest.approx(1.0, abs=1e-9) and whole.to_base < 0.99
    assert all(row.regime in (None, 1.0) for row in rows)
    assert {one.kind for one in scores} == {ALL, *KINDS}
    content = json.loads((tmp_path / "perfect" / "submission.json").read_text("utf-8"))
    schema = json.loads((exam.folder / exams.SUBMISSION_SCHEMA).read_text("utf-8"))
    Draft202012Validator.check_schema(schema)
    Draft202012Validator(schema).validate(content)
    assert not Draft202012Validator(schema).is_valid(content | {"extra": 1})


def test_an_empty_submission_is_right_about_the_controls_alone(made, tmp_path):
    exam, key, file = made
    _, rows = score(exam.folder, file, [submission(tmp_path / "empty", exam)])
    controls = {name for name, world in key.worlds.items() if world.kind == "nothing wrong"}
    assert {row.world for row in rows if row.alone} == controls
    assert all(row.to_base == pytest.approx(1.0) and not row.sizes for row in rows)
    assert [row.false_alarm for row in rows if row.world in controls] == [False] * len(controls)


def test_an_extended_model_is_simulated(made, tmp_path):
    """The base model itself as the extended one has the base model's errors."""
    exam, key, file = made
    worlds = {}
    path = submission(tmp_path / "own", exam)
    for name in key.worlds:
        (path.parent / f"{name}.json").write_bytes((exam.folder / name / exams.MODEL).read_bytes())
        worlds[name] = {"model": f"{name}.json"}
    submission(tmp_path / "own", exam, worlds=worlds)
    _, rows = score(exam.folder, file, [path])
    assert [row.to_base for row in rows] == pytest.approx([1.0] * COUNT, rel=1e-6)


WRONG = {
    "exam": ({"exam": "0" * 16}, "answers exam '0000000000000000'"),
    "world": ({"worlds": {"world-99": {}}}, "worlds world-99: the exam has no such world"),
    "key": ({"worlds": {"world-1": {"says": []}}}, "unknown key 'worlds world-1 says'"),
    "cause": ({"worlds": {"world-1": {"named": [{"cause": "gremlins"}]}}}, "world-1 named 0: unknown cause 'gremlins'"),
    "schema": ({"schema_version": 2}, "schema_version: needs 1"),
    "threshold": (
        {
            "worlds": {
                "world-1": {
                    "named": [{"cause": "wind", "regime": {"variable": "time", "side": "above", "threshold": "x"}}]
                }
            }
        },
        "regime threshold: needs a finite number",
    ),
    "interval": (
        {
            "worlds": {
                "world-1": {
                    "named": [{"cause": "wind", "sizes": [{"parameter": "speed", "value": 1, "low": 2, "high": 3}]}]
                }
            }
        },
        "world-1 named 0: size speed: low <= value <= high does not hold",
    ),
    "record": ({"worlds": {"world-1": {"motion": {"train-1": "a.csv"}}}}, "motion train-1: no such held-out record"),
    "outside": ({"worlds": {"world-1": {"motion": {"held_out-4": "../a.csv"}}}}, "'../a.csv' is outside its folder"),
    "absolute": ({"worlds": {"world-1": {"model": "/etc/passwd"}}}, "'/etc/passwd' is outside its folder"),
    "missing": ({"worlds": {"world-1": {"motion": {"held_out-4": "a.csv"}}}}, "a.csv: no such file"),
    "many": ({"worlds": {"world-1": {"named": [{"cause": "wind"}] * 21}}}, "worlds world-1 named"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_submission_that_cannot_be_used_is_refused_in_one_line(made, tmp_path, case):
    exam, _, file = made
    changes, told = WRONG[case]
    with pytest.raises(BadInput) as refused:
        score(exam.folder, file, [submission(tmp_path / "wrong", exam, **changes)])
    assert (told in str(refused.value) and "submission.json" in str(refused.value)) or case == "missing"
    assert told in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("text", ["NaN", "1e999", "-Infinity"])
def test_numbers_that_are_not_finite_are_refused(made, tmp_path, text):
    exam, _, _ = made
    path = submission(tmp_path / "wrong", exam, worlds={"world-1": {"named": [{"cause": "wind", "sizes": []}]}})
    size = f'[{{"parameter": "speed", "value": {text}}}]'
    path.write_text(path.read_text("utf-8").replace("[]", size), "utf-8")
    with pytest.raises(BadInput, match="number"):
        read_submission(path, exam)


def test_predicted_motion_is_checked(made, tmp_path):
    exam, key, file = made
    place = perfect(exam, key, tmp_path / "motion")
    path = place / "world-1-held_out-4.csv"
    lines = path.read_text("utf-8").splitlines()
    column = lines[0].split(",").index("yaw_rate_rad_s")

    def refused(changed, told):
        path.unlink()
        path.write_text("\n".join(changed) + "\n", "utf-8")
        with pytest.raises(BadInput, match=told):
            score(exam.folder, file, [place])

    refused(lines[:-1], "has not the times of the held-out record")
    cells = lines[-1].split(",")
    cells[column] = ""
    refused([*lines[:-1], ",".join(cells)], f"row {len(lines)}, column yaw_rate_rad_s: no finite number")
    cells[column] = "inf"
    refused([*lines[:-1], ",".join(cells)], "yaw_rate_rad_s: no finite number|is not a number")
    path.unlink()
    (tmp_path / "elsewhere.csv").write_text("\n".join(lines) + "\n", "utf-8")
    path.symlink_to(tmp_path / "elsewhere.csv")
    with pytest.raises(BadInput, match="is reached by a link"):
        score(exam.folder, file, [place])


def test_a_submission_or_an_exam_behind_a_link_is_not_read(made, tmp_path):
    exam, _, file = made
    path = submission(tmp_path / "own", exam)
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / "submission.json").symlink_to(path)
    with pytest.raises(BadInput, match="is a link"):
        score(exam.folder, file, [tmp_path / "link"])
    with pytest.raises(BadInput, match="no such file"):
        score(tmp_path / "own", file, [path])


def test_the_key_and_the_files_are_those_of_the_exam(made, tmp_path):
    exam, _, file = made
    other = tmp_path / "key.json"
    other.write_bytes(file.read_bytes() + b"\n")
    with pytest.raises(BadInput, match="is not the key of this exam"):
        exam.key(other)
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in exam.folder.rglob("*.*"):
        place = copy / path.relative_to(exam.folder)
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(path.read_bytes())
    (copy / "world-1" / "train-1.csv").write_bytes((copy / "world-2" / "train-1.csv").read_bytes())
    with pytest.raises(BadInput, match=r"world-1/train-1.csv: was changed since the exam was made"):
        score(copy, file, [submission(tmp_path / "own", exam)])
    manifest = json.loads((copy / exams.MANIFEST).read_text("utf-8"))
    manifest["files"]["world-1/train-1.csv"] = manifest["files"]["world-2/train-1.csv"]
    (copy / exams.MANIFEST).write_text(json.dumps(manifest), "utf-8")
    with pytest.raises(BadInput, match="was changed since the exam was made"):
        score(copy, file, [submission(tmp_path / "own", exam)])


def test_nothing_is_left_of_an_exam_that_cannot_be_made(made, tmp_path):
    exam, _, file = made

    def refused(folder, key, told, **more):
        before = sorted(tmp_path.rglob("*"))
        with pytest.raises(BadInput, match=told):
            exams.make(folder, key, folder_texts, vessels=("response-1",), **more)
        assert sorted(tmp_path.rglob("*")) == before

    refused(exam.folder, tmp_path / "key.json", "is not empty")
    refused(tmp_path / "new", file, "exists already")
    refused(tmp_path / "new", tmp_path / "new" / "key.json", "no such directory")
    (tmp_path / "empty").mkdir()
    refused(tmp_path / "empty", tmp_path / "empty" / "key.json", "lies in the folder that is handed out")
    refused(tmp_path / "new", tmp_path / "key.json", "500 worlds", count=500)
    refused(tmp_path / "new", tmp_path / "key.json", "no suite of diagnoses", suite="quick", count=1)

    def fails(*_):
        raise BadInput("no texts")

    with pytest.raises(BadInput, match="no texts"):
        exams.make(tmp_path / "new", tmp_path / "key.json", fails, count=1, vessels=("response-1",))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty"]


def row(entrant="a", **changes):
    """An answer that is right, with changes."""
    facts = {
        "world": "w", "kind": "sensors", "outcome": "alone", "named": "", "points": 1, "alone": True,
        "right_share": 1.0, "false_alarm": None, "sizes": (), "regime": None, "predicted": True,
        "to_base": 0.5, "to_best": 2.0,
    }  # fmt: skip
    return WorldScore(entrant, **(facts | changes))


def test_scores_of_answers_written_by_hand_are_exact():
    rows = [
        row(sizes=(EffectSizes(0.1, 0.5, 0.4), EffectSizes(None, 1.0, None)), right_share=0.5),
        row(points=-1, alone=False, right_share=0.0, sizes=(EffectSizes(0.2, None, 0.2),), to_base=2.0, to_best=8.0),
        row(kind="nothing wrong", alone=False, right_share=None, false_alarm=True, to_base=1.0, to_best=1.0),
        row(kind="regime", alone=False, regime=0.5, predicted=False, to_base=1.0, to_best=1.0),
        row("b", alone=False),
    ]
    whole, regime, sensors, control, other, _ = summary(rows)
    assert (whole.kind, whole.worlds, whole.alone, whole.right_share, whole.false_alarms) == (ALL, 4, 0.25, 0.5, 1.0)
    assert (whole.sizes, whole.wrong_size, whole.coverage) == (3, pytest.approx(0.15), 0.75)
    assert (whole.points, other.points) == (0.5, 1.0)
    assert (whole.interval, whole.regime, whole.predicted) == (pytest.approx(0.3), 0.5, 0.75)
    assert (whole.to_base, whole.to_best) == (pytest.approx(1.0), pytest.approx(2.0))
    assert (sensors.kind, sensors.alone, sensors.to_best) == ("sensors", 0.5, pytest.approx(4.0))
    assert (regime.kind, regime.regime, control.kind, control.right_share) == ("regime", 0.5, "nothing wrong", None)
    assert (other.entrant, other.worlds, other.alone) == ("b", 1, 0.0)


@pytest.mark.parametrize(
    ("named", "base", "injected", "outcome"),
    [
        ([], "off-5", (), "adequate"),
        (["group:rudder_effectiveness"], "off-5", (), "adequate"),
        (["rudder_effectiveness"], "off-5", (), "false_alarm"),
        (["group:rudder_effectiveness"], "exact", (), "false_alarm"),
        (["rudder_effectiveness", "group:hull_yaw_linear"], "off-5", ("rudder_effectiveness",), "alone"),
        (["group:hull_yaw_linear"], "N_r", (), "alone"),
        (["group:hull_yaw_linear/group:hull_sway_linear"], "N_r", (), "tie"),
        (["group:hull_sway_linear", "group:hull_yaw_linear"], "N_r", (), "among"),
        (["wind", "current"], "exact", ("wind",), "alone"),
    ],
)
def test_names_of_groups_and_causes_are_told_apart(named, base, injected, outcome):
    facts = [text.split("/") for text in named]
    said = WorldAnswer.model_validate({"named": [{"cause": one[0], "tied_with": one[1:]} for one in facts]})
    group = "injected" if injected else "null" if base in ("off-5", "exact") else "one-bug"
    spec = CaseSpec("exam", "", "", group, "mariner", injected, "none", "none", 1, base)
    key = WorldKey.model_construct(case=spec, right=tuple(right_names(spec)[0]))
    assert naming(stated(said, resolve("mariner")), key)["outcome"] == outcome


def test_errors_count_behind_the_opening_and_headings_by_the_smaller_angle():
    heading, rate = np.array([0.0, 0.0, 3.1, -3.1]), np.array([9.0, 1.0, np.nan, 1.0])
    measured = {"a": {"heading_rad": heading, "yaw_rate_rad_s": rate}}
    runs = {"a": {"heading_rad": np.array([9.0, 0.0, -3.1, 3.1]), "yaw_rate_rad_s": np.array([0.0, 0.0, 0.0, 3.0])}}
    found = errors(measured, runs, {"a": 1})
    angle = 2.0 * np.pi - 6.2
    assert found == pytest.approx({"heading_rad": angle * np.sqrt(2 / 3), "yaw_rate_rad_s": np.sqrt(5 / 2)})
    assert errors(measured, {"a": {"heading_rad": heading}}, {"a": 1}) == {"heading_rad": 0.0}
    assert error(np.array([1.0, np.nan]), np.array([np.nan, np.nan]), "surge_m_s")[0] == 1e6


@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7", "cargo"])
def test_a_ship_of_its_own_is_the_same_in_simulator_and_model(vessel, rng):
    """The truth simulator and the model move alike with the same factors on the published numbers."""
    factors = tuple((name, 1.04 if i % 2 else 0.96) for i, name in enumerate(sister_numbers(vessel)))
    case = FaultCase(vessel, factors=factors, noise=0.0, train=("zigzag:10/10",), held_out=("turn:15",))
    case = replace(case, duration_s=60.0 if vessel == "kvlcc2-l7" else 200.0)
    records = inject(case, rng).train
    known = numbers_of(resolve(vessel))
    model = with_numbers(resolve(vessel), {name: known[name] * factor for name, factor in factors})
    run, published = (predicted(one, records)["train-1"]["yaw_rate_rad_s"] for one in (model, resolve(vessel)))
    rate = records[0].column("yaw_rate_rad_s")
    assert np.std(rate - run) < 0.02 * np.std(rate) and np.std(rate - run) < 0.5 * np.std(rate - published)


def test_a_wrong_number_is_no_further_from_the_published_one_than_others_may_be(seed):
    specs = [s for s in plan(load_suite("exam"), RunSelection("exam", ("innovations",), seed=seed)) if is_hidden(s)]
    bugs = [spec for spec in specs if bug_of(spec.vessel, spec.base) is not None]
    assert len(bugs) >= 15
    limit = MOST * SPREAD + 0.5 * max(abs(np.log(HIDDEN)))
    for spec in bugs[:3]:
        bug, factors = bug_of(spec.vessel, spec.base), dict(sister(spec))
        for name, wrong in bug.factors.items():
            assert abs(np.log(wrong * factors[name])) <= limit
            true = ship(spec.vessel, tuple(factors.items()))
            assert name not in true.names or true.coefficient(name) == pytest.approx(
                ship(spec.vessel).coefficient(name) * factors[name]
            )


@pytest.mark.nightly
def test_the_commands_make_answer_and_score(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make = ["exam", "make", "exam", "--key", "key.json", "--worlds", "2", "--vessel", "response-1"]
    assert status_of(make) == 0 and "README.md says what to hand in" in capsys.readouterr().out
    assert status_of(make) == 2 and "is not empty" in capsys.readouterr().err
    assert status_of(["exam", "answer", "exam", "--diagnoser", "nothing", "-o", "nothing"]) == 0
    assert status_of(["exam", "answer", "exam", "--diagnoser", "nothing", "-o", "nothing"]) == 2
    capsys.readouterr()
    assert status_of(["exam", "score", "exam", "nothing", "--key", "key.json", "-o", "scores"]) == 0
    assert "By kind of world\n" in capsys.readouterr().out
    assert sorted(p.name for p in (tmp_path / "scores").iterdir()) == ["scores.csv", "scores.json", "scores.md"]
    found = helmbench.score_exam("exam", "nothing", "key.json")
    assert len(found.answers) == 2 and all(row.named == "" for row in found.answers)
    assert len(found.to_dataframe()) == len(found.scores) == 3


def test_the_opening_of_a_record_is_its_first_part():
    time = np.arange(0.0, 100.5, 0.5)
    record = Record(time, {"rudder_rad": np.zeros(time.size)}, "held")
    shown = opening(record)
    assert time[shown - 2] < FIRST_PART * 100.0 <= time[shown - 1]
