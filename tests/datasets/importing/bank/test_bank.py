"""A bank of small raw logs with known truth: nothing goes in wrong without a word, and answers to questions suffice."""

import numpy as np
import pytest

import helmbench

from ....seeds import seed_of
from .case import ROUNDS, Case, Outcome, answer, truth_of
from .format_cases import FORMAT_CASES
from .hostile_cases import HOSTILE_CASES
from .other_cases import OTHER_CASES
from .sentence_cases import SENTENCE_CASES
from .text_cases import TEXT_CASES
from .truth import sail

CASES = {**TEXT_CASES, **HOSTILE_CASES, **OTHER_CASES, **SENTENCE_CASES, **FORMAT_CASES}


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


def error_of(record, channel: str, run, side: str) -> float:
    """Root mean square error of a channel over its range; positions from their first sample."""
    true = np.interp(record.time_s, run.t, truth_of(run, channel))
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


def tried(case: Case, run, folder) -> Outcome:
    files = case.write(run, folder)
    found, asked, note, columns = import_case(case, files)
    unnamed = tuple(c.column for c in columns if not c.why) if columns else ("no column",)
    if found is None:
        return Outcome(False, asked, (), (), unnamed, note)
    record = found.record
    side = record.meta.positive_rudder
    errors = {c: error_of(record, c, run, side) for c in record.channels if c in KNOWN}
    wrong = tuple(f"{c} {e:.2g}" for c, e in errors.items() if not e < case.loose)
    missing = tuple(c for c in case.wanted if c not in record.channels)
    return Outcome(not missing, asked, wrong, missing, unnamed)


KNOWN = (
    "rudder_rad", "rudder_command_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "roll_rad", "north_m",
    "east_m", "propeller_rps",
)  # fmt: skip


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    rng = np.random.default_rng(seed_of("bank of logs"))
    made = {}
    for i, (name, case) in enumerate(CASES.items()):
        made[name] = tried(case, sail(rng), tmp_path_factory.mktemp(f"log{i}"))
    print(table(made))
    return made


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


def test_formats_that_state_what_they_hold_are_imported_with_the_questions_they_need(outcomes):
    shown = {name: (o.imported, o.asked, o.missing, o.note) for name, o in outcomes.items() if name in FORMAT_CASES}
    wrong = {name: o for name, o in shown.items() if not o[0] or o[1] > FORMAT_CASES[name].questions}
    assert wrong == {}


def test_every_column_is_named(outcomes):
    assert {name: o.unnamed for name, o in outcomes.items() if o.unnamed} == {}
