"""What a diagnosis suite runs: cases drawn from the run's seed, and who diagnoses them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import cycle
from typing import Any

import numpy as np

from ....datasets import randomness
from ....diagnosis.registry import find
from ....models.errors import BadInput
from ....models.plain import EXACT_BELOW
from ....models.suggestions import suggestion
from ..base import RunSelection, Suite, limited
from .bases import BUGS, EXACT, carried
from .columns import KEYS
from .suite import CasesEntry

NOTHING, PLAIN, ONE_BUG, REGIME, PLANTED = "none", "plain", "one-bug", "regime", "planted-null"
ORACLE = "oracle"
"""Name in the tables of the diagnosis that is given the true causes: a bound on the gain, not a competitor."""


@dataclass(frozen=True)
class CaseSpec:
    """One case for one diagnoser; `maker` is what `diagnosis.registry.make` takes.

    With `seed` and the other fields the truth simulator makes the same records again (`faults.inject`).
    base : what is wrong with the base model itself (`bases.BASES`).  records : how they are made (`records.RECORDS`).
    """

    suite: str
    method: str
    maker: str
    group: str
    vessel: str
    injected: tuple[str, ...]
    strength: str
    gusts: str
    seed: int
    base: str = EXACT
    records: str = PLAIN

    @property
    def key(self) -> str:
        """Identifier that is the same in every process and session."""
        text = json.dumps(asdict(self), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:20]

    def row_key(self) -> dict[str, Any]:
        """The key columns of the tables."""
        return {name: getattr(self, name) for name in KEYS} | {"injected": "+".join(self.injected)}


def with_seed(selection: RunSelection) -> RunSelection:
    """The selection with a seed: its own, or one drawn anew."""
    if selection.seed is not None:
        return selection
    return replace(selection, seed=randomness.drawn_seed())


def plan(suite: Suite, selection: RunSelection) -> list[CaseSpec]:
    """Every case of a suite and diagnoser: the same for the same seed, and more rounds only add to it.

    Raises `BadInput` for unknown diagnosers, vessels or causes, and where nothing is left to run.
    """
    makers = [(_name_of(maker), maker) for maker in selection.methods or suite.head.methods]
    once = [] if selection.methods else [(_name_of(maker), maker) for maker in suite.head.compare]
    selection = with_seed(selection)
    _check_vessels(suite, selection)
    specs = limited(_specs(suite, selection, makers, once), suite.name)
    if not specs:
        raise BadInput("nothing to run", file=f"suite {suite.name}", hint="the filters leave no case of it")
    return specs


def _specs(
    suite: Suite, selection: RunSelection, makers: Sequence[tuple[str, str]], once: Sequence[tuple[str, str]]
) -> Iterator[CaseSpec]:
    """Cases in order; `once` are diagnosers (name, maker) of the first round only."""
    for turn in range(selection.seeds or suite.head.seeds):
        for number, entry in enumerate(suite.entries):
            rng = np.random.default_rng([selection.seed or 0, turn, number])
            draw = bug_cases if entry.group == ONE_BUG else draw_cases
            for case in draw(suite.name, entry, rng):
                if selection.vessels and case.vessel not in selection.vessels:
                    continue
                for name, maker in makers if turn else [*makers, *once]:
                    yield replace(case, method=name, maker=maker)
                if entry.oracle:
                    yield replace(case, method=ORACLE)


def draw_cases(suite: str, entry: CasesEntry, rng: np.random.Generator) -> Iterator[CaseSpec]:
    """One round of an entry: each text of `inject` `each` times, with stratified draws of the rest."""
    strengths, gusts = stratified(entry.strength, rng), stratified(entry.gusts, rng)
    bases, records = stratified(entry.base, rng), stratified(entry.records, rng)
    for text in _texts(entry.inject):
        injected = () if text == NOTHING else tuple(text.split("+"))
        carriers = _carriers(entry, injected)
        vessels: dict[str, Iterator[str]] = {
            base: stratified([v for v in carriers if carried(base, v)], rng) for base in entry.base
        }
        for _ in range(entry.each):
            base = next(bases)
            strength = next(strengths) if injected else NOTHING
            seed = int(rng.integers(EXACT_BELOW))
            vessel, weather = next(vessels[base], carriers[0]), next(gusts)
            kind = next(records)
            yield CaseSpec(suite, "", "", entry.group, vessel, injected, strength, weather, seed, base, kind)


def bug_cases(suite: str, entry: CasesEntry, rng: np.random.Generator) -> Iterator[CaseSpec]:
    """One round of an entry of single bugs: each bug of its vessels `each` times."""
    gusts, records = stratified(entry.gusts, rng), stratified(entry.records, rng)
    for bug in BUGS:
        for _ in range(entry.each if not entry.vessels or bug.vessel in entry.vessels else 0):
            seed, weather = int(rng.integers(EXACT_BELOW)), next(gusts)
            yield CaseSpec(suite, "", "", ONE_BUG, bug.vessel, (), NOTHING, weather, seed, bug.id, next(records))


def stratified(values: Sequence[str], rng: np.random.Generator) -> Iterator[str]:
    """Values without end, in random order; each comes once before any comes again."""
    for _ in cycle([None] if len(values) else []):
        yield from (values[int(i)] for i in rng.permutation(len(values)))


def _texts(inject: Sequence[str]) -> list[str]:
    from ...faults import ANTICIPATED, TAXONOMY, UNFORESEEN, names_of

    groups = {group: names_of(group) for group in (TAXONOMY, ANTICIPATED, UNFORESEEN, REGIME)}
    return [text for name in inject for text in groups.get(name, (name,))]


def _carriers(entry: CasesEntry, injected: Sequence[str]) -> list[str]:
    """Vessels of an entry that can carry all the effects."""
    from ...faults import VESSELS, kind_of
    from ...faults.ships import ship

    kinds = [kind_of(cause) for cause in injected]
    vessels = entry.vessels or VESSELS
    found = [name for name in vessels if all(kind.carried_by(ship(name)) for kind in kinds)]
    if not found:
        raise BadInput(f"no vessel of the entry can carry {'+'.join(injected)}")
    return found


def _check_vessels(suite: Suite, selection: RunSelection) -> None:
    from ...faults import VESSELS

    known = {vessel for entry in suite.entries for vessel in entry.vessels or VESSELS}
    for vessel in sorted(known - set(VESSELS)):
        hint = suggestion(vessel, VESSELS, f"the truth simulator has {', '.join(VESSELS)}")
        raise BadInput(f"unknown vessel {vessel!r}", file=f"suite {suite.name}", hint=hint)
    for vessel in selection.vessels:
        if vessel not in known:
            hint = suggestion(vessel, known, f"it has {', '.join(sorted(known))}")
            raise BadInput(f"suite {suite.name} has no vessel {vessel!r}", hint=hint)


def _name_of(maker: str) -> str:
    return find(maker).name
