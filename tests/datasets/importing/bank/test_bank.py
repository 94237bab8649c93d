"""A bank of small raw logs with known truth: nothing goes in wrong without a word, and answers to questions suffice."""

import datetime
from functools import partial

import numpy as np
import pytest

import helmbench

from ....nightly_marks import nightly_but
from ....seeds import SHIFT, seed_of
from ....support.inline_reader import without_processes
from .case import ROUNDS, Case, CaseOutcome, answer, truth_of
from .choice_cases import CHOICE_CASES
from .clock_cases import CLOCK_CASES
from .exam_cases import EXAM_CASES
from .format_cases import FORMAT_CASES
from .hostile_cases import HOSTILE_CASES
from .nameless_cases import NAMELESS_CASES
from .other_cases import OTHER_CASES
from .program_cases import PROGRAM_CASES
from .sentence_cases import SENTENCE_CASES
from .text_cases import TEXT_CASES
from .truth import START, sail

CASES = {
    **TEXT_CASES, **HOSTILE_CASES, **OTHER_CASES, **SENTENCE_CASES, **CLOCK_CASES, **CHOICE_CASES, **FORMAT_CASES,
    **NAMELESS_CASES, **PROGRAM_CASES, **EXAM_CASES,
}  # fmt: skip
ALIKE = (*TEXT_CASES, *HOSTILE_CASES, *OTHER_CASES, *SENTENCE_CASES)
"""Logs of which several differ in little: `make test` imports every second one, `make test-all` each."""
IMPORTED = {name for name in CASES if SHIFT or name not in ALIKE[1::2]}


def import_case(case: Case, files) -> tuple[object, int, str, list]:
    """(import or None, answers given, why not, columns of the last draft)."""
    answers: dict[str, str] = {}
    try:
        draft = helmbench.draft_import(files, **case.options)
    except helmbench.BadInput as error:
        return None, 0, str(error), []
    for _ in range(ROUNDS):
        if not draft.questions:
            break
        given = {question.id: key for question in draft.questions if (key := answer(question, case)) is not None}
        fresh = {key: value for key, value in given.items() if answers.get(key) != value}
        if not fresh:
            texts = "; ".join(question.text for question in draft.questions)
            return None, len(answers), f"no answer is right: {texts}", list(draft.columns)
        answers |= fresh
        draft = draft.answer(fresh)
    try:
        return draft.import_log(), len(answers), "", list(draft.columns)
    except helmbench.BadInput as error:
        return None, len(answers), str(error), list(draft.columns)


def start_of(record) -> tuple[str, float]:
    """(under which key a record states its start, that in seconds since 1970); ('', 0) where it states none."""
    for key in ("start_utc", "start_of_unknown_zone"):
        if key in record.meta.extra:
            moment = datetime.datetime.fromisoformat(record.meta.extra[key])
            return key, moment.replace(tzinfo=datetime.UTC).timestamp()
    return "", 0.0


def error_of(record, channel: str, run, side: str, first_s: float) -> float:
    """Root mean square error of a channel over its range; positions from their first sample."""
    true = np.interp(record.time_s + first_s, run.t, truth_of(run, channel))
    got = record.continuous(channel)
    if channel in ("rudder_rad", "rudder_command_rad"):
        got = got if side == "starboard" else -got
    known = np.isfinite(got)
    got, true = got[known], true[known]
    if channel in ("north_m", "east_m"):
        got, true = got - got[0], true - true[0]
    if channel == "heading_rad":
        got = got - 2.0 * np.pi * np.round(np.mean(got - true) / (2.0 * np.pi))
    return float(np.sqrt(np.mean((got - true) ** 2)) / np.ptp(true))


def tried(case: Case, run, folder) -> CaseOutcome:
    files = case.write(run, folder)
    found, asked, note, columns = import_case(case, files)
    unnamed = tuple(c.column for c in columns if not c.why) if columns or case.refused else ("no column",)
    if found is None:
        return CaseOutcome(False, asked, (), (), unnamed, note)
    record = max(found.records, key=lambda record: record.n)
    key, start = start_of(record)
    side = record.meta.positive_rudder
    first = start - START if key == "start_utc" else 0.0  # the start itself is judged by the tests of clocks
    of_thrust = {"rudder_command_rad"} if record.has("thrust_port_N") else set()
    errors = {c: error_of(record, c, run, side, first) for c in record.channels if c in set(KNOWN) - of_thrust}
    wrong = tuple(f"{c} {e:.2g}" for c, e in errors.items() if not e < case.loose)
    missing = tuple(c for c in case.wanted if c not in record.channels)
    said = "; ".join(map(str, found.report.faults))
    again = partial(differences, found, files, folder / "map.yaml")
    return CaseOutcome(not missing, asked, wrong, missing, unnamed, "", len(found.records), key, start, said, again)


def differences(found, files, path) -> tuple[str, ...]:
    """What differs where files are imported again with the map that an import wrote."""
    found.write_mapping(path)
    try:
        other = helmbench.import_log(files, mapping=path)
    except helmbench.BadInput as error:
        return (str(error),)
    if [r.name for r in found.records] != [r.name for r in other.records]:
        return ("other records",)
    pairs = list(zip(found.records, other.records, strict=True))
    facts = [f"{a.name}: {a.meta.extra} {b.meta.extra}" for a, b in pairs if a.meta.extra != b.meta.extra]
    sets = [f"{a.name}: {set(a.channels) ^ set(b.channels)}" for a, b in pairs if set(a.channels) != set(b.channels)]
    channels = [
        f"{a.name}: {name}"
        for a, b in pairs
        for name in {*a.channels} & {*b.channels}
        if not np.array_equal(a.channels[name], b.channels[name], equal_nan=True)
    ]
    return (*facts, *sets, *channels)


PARTS = 4
"""Parts of the bank; one of them is imported again with its map by `make test`."""
KNOWN = (
    "rudder_rad", "rudder_command_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "roll_rad", "north_m",
    "east_m", "propeller_rps",
)  # fmt: skip


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    rng = np.random.default_rng(seed_of("bank of logs"))
    made = {}
    with without_processes(but_first=True):
        for i, (name, case) in enumerate(CASES.items()):
            run = sail(rng, seconds=case.seconds)
            if name in IMPORTED:
                made[name] = tried(case, run, tmp_path_factory.mktemp(f"log{i}"))
        print(table(made))
        yield made


def table(made) -> str:
    lines = [f"{'log':44} {'hostile':8} {'imported':9} {'asked':6} faults"]
    for name, o in made.items():
        what = [*(f"WRONG {w}" for w in o.wrong), *(f"missing {m}" for m in o.missing), *([o.note] if o.note else [])]
        hostile, imported = "yes" if CASES[name].hostile else "", "yes" if o.imported else "no"
        lines.append(f"{name[:44]:44} {hostile:8} {imported:9} {o.asked:<6} {'; '.join(what)}")
    done = sum(o.imported for o in made.values())
    lines.append(f"{done} of {len(made)} imported, {sum(bool(o.wrong) for o in made.values())} with a silent error")
    return "\n".join(lines)


def test_nothing_goes_in_wrong_without_a_word(outcomes):
    assert {name: o.wrong for name, o in outcomes.items() if o.wrong} == {}


def test_answers_to_questions_suffice(outcomes):
    assert len(outcomes) >= 40 and sum(CASES[name].hostile for name in outcomes) >= len(outcomes) / 2
    assert sum(o.imported for o in outcomes.values()) >= 0.85 * len(outcomes)


@pytest.mark.parametrize("part", nightly_but(range(PARTS), 0))
def test_the_map_that_an_import_wrote_gives_the_same_records(outcomes, part):
    logs = [name for name, outcome in outcomes.items() if outcome.again is not None][part::PARTS]
    assert {name: differs for name in logs if (differs := outcomes[name].again())} == {}


@pytest.mark.parametrize("name", CLOCK_CASES)
def test_clocks_runs_and_names_over_several_cells(outcomes, name):
    case, found = CASES[name], outcomes[name]
    if case.refused:
        assert not found.imported and case.refused in found.note
        return
    assert found.imported and not found.wrong, found
    assert (found.asked, found.records, found.start) == (case.questions, case.records, case.start)
    assert case.said in found.said
    if case.start:
        assert found.start_s == pytest.approx(START + case.first_s, abs=case.within_s)


def test_no_more_is_asked_than_is_needed(outcomes):
    most = {
        name: case.questions
        for name, case in (CHOICE_CASES | NAMELESS_CASES | PROGRAM_CASES | EXAM_CASES).items()
        if case.questions is not None
    }
    assert {name: outcomes[name].asked for name in most} == most
    assert {name: outcomes[name].note for name in most if not outcomes[name].imported} == {}


def test_formats_that_state_what_they_hold_are_imported_with_the_questions_they_need(outcomes):
    shown = {name: (o.imported, o.asked, o.missing, o.note) for name, o in outcomes.items() if name in FORMAT_CASES}
    wrong = {name: o for name, o in shown.items() if not o[0] or o[1] > FORMAT_CASES[name].questions}
    assert wrong == {}


def test_every_column_is_named(outcomes):
    assert {name: o.unnamed for name, o in outcomes.items() if o.unnamed} == {}
