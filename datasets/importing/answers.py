"""What the answers to the questions about a column say of it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace

from ...models.data_file import yaml_of
from ...models.errors import BadInput
from .draft import NOT_USED, Answer, Question
from .finding import ColumnFinding
from .mapping import ColumnMap
from .quantities import quantities
from .reading import UNSIGNED, goes_ahead
from .units import UNITS


def answered(found: ColumnFinding, answers: Mapping[str, str]) -> ColumnFinding:
    """The finding with what its questions' answers say."""
    for question in found.questions:
        key = answers.get(question.id)
        if key is not None:
            rest = tuple(q for q in found.questions if q is not question)
            found = _with_answer(replace(found, questions=rest), question, key)
    return found


def _with_answer(found: ColumnFinding, question: Question, key: str) -> ColumnFinding:
    answer = question.answer(key) or _as_number(question, key)
    if answer is None:
        known = ", ".join(answer.key for answer in question.answers)
        raise BadInput(f"{key!r} is no answer to {question.id!r}", hint=f"give one of: {known}")
    entry = ColumnMap.model_validate(yaml_of(answer.line.encode(), "answer")[0][0])
    if entry.to == NOT_USED:
        return found.unused("not used, as answered")
    base = replace(found, sure="stated", why=(*found.why, "as answered"), bounded=(*found.bounded, question.about))
    if question.about == "unit":
        unit = UNITS.get(str(entry.unit))
        return replace(base, unit=unit, factor=entry.factor, offset=entry.offset, foreign="")
    if question.about == "numbers":
        return replace(base, factor=entry.factor)
    if question.about == "sign":
        return replace(base, signed=True, sign=1 if entry.sign == "?" else entry.sign, offset=entry.offset)
    may_be = (entry.to,)
    same = quantities()[entry.to].dimension == base.dimension
    chosen = replace(base, may_be=may_be, unit=base.unit if same else None)
    signed = base.signed if len(found.may_be) == 1 else entry.to in UNSIGNED or goes_ahead(chosen)
    return replace(chosen, signed=signed)


def _as_number(question: Question, key: str) -> Answer | None:
    """The answer that a number is: the first one with a factor, as much larger."""
    try:
        size = float(key)
    except ValueError:
        return None
    scaled = next((a for a in question.answers if "factor:" in a.line or question.number), None)
    if not question.number or scaled is None or not size:
        return None
    made = next((a for a in question.answers if a.key.replace(".", "", 1).isdigit()), scaled)
    entry = yaml_of(made.line.encode(), "answer")[0][0]
    entry["factor"] = entry.get("factor", 1.0) * size / float(made.key)
    entry["offset"] = entry.get("offset", 0.0) * size / float(made.key)
    return Answer(key, f"{size:g}", f"- {json.dumps(entry)}")
