"""Suite files of kind `diagnosis`: effects are injected in simulated records, and what diagnosers say is scored.

Entries are stratified draws: every round injects each text of `inject` `each` times; vessel, strength and gusts are
drawn so that each value comes once before any comes again.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ....models.yaml_file import Count, FileContent, Flag, Text, Texts, needs

Group = Annotated[
    Literal["injected", "null", "anticipated", "unforeseen", "pair", "one-bug", "regime", "planted-null"],
    needs("injected, null, anticipated, unforeseen, pair, one-bug, regime or planted-null"),
]

Base = Annotated[
    Literal["exact", "unstated", "off-5", "off-10", "off-20", "dropped", "particulars", "other-family"],
    needs("exact, unstated, off-5, off-10, off-20, dropped, particulars or other-family"),
]
Made = Annotated[
    Literal["plain", "coloured", "spread", "closed-loop", "orders", "five-three", "five-steps"],
    needs("plain, coloured, spread, closed-loop, orders, five-three or five-steps"),
]


class CasesHead(FileContent):
    """Keys of the file beside its entries.

    seeds : number of rounds.
    methods : diagnosers, such as `innovations` or `path.py:Class`.
    compare : diagnosers that take part in the first round only.
    """

    title: Text = ""
    kind: Literal["diagnosis"]
    seeds: Count = 1
    methods: Texts
    compare: Texts = ()


class CasesEntry(FileContent):
    """Cases of one group.

    group : how the answer is scored; `one-bug` takes each of `bases.BUGS` `each` times instead of injecting anything,
        `planted-null` injects the forces of effects as they act in another record.
    inject : causes joined by +, `none`, or all `causes`, `anticipated`, `unforeseen` or `regime` kinds.
    vessels : ids (default: those of the truth simulator); those that cannot carry an effect are left out.
    strength : names of `faults.STRENGTHS` or `faults.SIZED`; gusts : names of `faults.GUSTS`.
    each : cases of each text in a round.
    oracle : the true causes are refitted as well, to compare the gain with.
    base : what is wrong with the base model itself; records : how they are made.
    """

    group: Group = "injected"
    inject: Texts = ("causes",)
    vessels: Texts = ()
    strength: Texts = ("medium",)
    gusts: Texts = ("none",)
    each: Count = 1
    oracle: Flag = False
    base: Annotated[tuple[Base, ...], Field(min_length=1), needs("a list of bases")] = ("exact",)
    records: Annotated[tuple[Made, ...], Field(min_length=1), needs("a list of kinds of records")] = ("plain",)


MODELS = (CasesHead, CasesEntry)
