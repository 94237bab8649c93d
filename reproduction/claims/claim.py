"""Claims of a paper, its errata, its figures, and independent references, as a claims file holds them."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, StrictFloat, StrictInt, model_validator

from ...models.errors import BadInput
from ...models.yaml_file import FileContent, Flag, Text, needs

Number = Annotated[StrictInt | StrictFloat, needs("a number")]
Kind = Annotated[Literal["result", "setting", "echo", "derived"], needs("one of result, setting, echo, derived")]
Form = Annotated[Literal["value", "at_most", "at_least", "holds"], needs("one of value, at_most, at_least, holds")]
Scale = Annotated[Literal["linear", "log"], needs("linear or log")]
Reason = Annotated[Text | dict[str, Text], needs("a sentence, or one for each verdict")]
RESULT, DERIVED = "result", "derived"
KINDS = (RESULT, "setting", "echo", DERIVED)
WIDEST = 1.0
"""An interval wider than this multiple of the published value reproduces nothing."""
ROMAN = {"i": 1, "ii": 2, "iii": 3, "iv": 4, "v": 5, "vi": 6, "vii": 7, "viii": 8, "ix": 9, "x": 10}


class Tolerance(FileContent):
    """What counts as equal: `relative` of the published value, or `absolute` in its unit, or the larger of both."""

    relative: Number = 0.0
    absolute: Number = 0.0

    def around(self, value: float) -> float:
        """Half the width of the interval that counts as `value`."""
        return max(abs(value) * self.relative, self.absolute)


class Reference(FileContent):
    """What an independent computation of the same quantity gave: ours must lie within the tolerance of it.

    With `form` 'at_most' or 'at_least' it is a bound that ours must keep.

    `study` and `key` default to those of the claim it belongs to (`corrected`).
    """

    value: Number
    tolerance: Tolerance
    id: Text = ""
    quantity: Text = ""
    unit: Text = ""
    study: Text = ""
    key: Text = ""
    form: Form = "value"
    note: Text = ""


class Claim(FileContent):
    """One number or statement of a paper, and how it is computed.

    Parameters
    ----------
    item : table, figure or section, "Table 5".
    kind : 'result' of an experiment or a calculation; 'setting' of one; 'echo', a number that repeats others: a
        coefficient of a source, or arithmetic of numbers printed beside it; 'derived', a number that the paper does
        not print and that we computed from printed ones.
    published : the number as printed (as computed, of a derived claim), in `unit`; true for a statement.
    form : 'value'; 'at_most' and 'at_least' for bounds; 'holds' for a statement.
    study, corrected, as_printed : the study and the keys of its values under corrected and printed equations.
    protocol : how it is computed, and what the paper leaves unsaid.
    equation : the wrong equation, "(26)".
    reason : one sentence, or one for each verdict (`open`: for all that are neither reproduced nor contradicted);
        {published}, {corrected}, {as_printed}, {low}, {high} are filled in.
    missing : why nothing can be computed, instead of a study.
    unused : of a setting, why no study takes it, instead of a study.
    unprinted : the decisive setting that the paper does not print; whatever we find, the claim is at most consistent.
    censored : a run without a number would have had one after the record's end: right-censored.
    stated : everything that decides the value is printed, so that a disagreement contradicts the claim.
    search : the study that computes the same keys over the range of what is not printed (see `SettingSearch`); only a
        value that this range does not hold is contradicted.
    nonzero : the value only counts as reproduced by an interval that excludes zero; for coefficients that records may
        not determine at all.
    widest : an interval wider than this multiple of the published value reproduces nothing; of values 1, of bounds
        without limit where it is not given.
    scale : 'log' for errors and other positive sizes, whose interval is taken of the logarithms; 'linear'.
    """

    id: Text
    item: Text
    kind: Kind
    quantity: Text
    published: Any
    unit: Text = ""
    form: Form = "value"
    tolerance: Tolerance = Tolerance()
    study: Text = ""
    corrected: Text = ""
    as_printed: Text = ""
    protocol: Text = ""
    equation: Text = ""
    reason: Reason = ""
    missing: Text = ""
    unused: Text = ""
    unprinted: Text = ""
    censored: Flag = False
    stated: Flag = False
    search: Text = ""
    nonzero: Flag = False
    widest: Number | None = None
    scale: Scale = "linear"
    reference: Reference | None = None

    @model_validator(mode="after")
    def _can_be_computed(self) -> Claim:
        if [bool(self.missing), bool(self.unused), bool(self.study)].count(True) != 1:
            raise ValueError("needs either a study or what is missing")
        if self.study and not self.corrected:
            raise ValueError("needs the key of the corrected value")
        if self.form == "holds" and not isinstance(self.published, bool):
            raise ValueError("published must be true or false")
        number = isinstance(self.published, int | float) and math.isfinite(self.published)
        if self.study and self.form != "holds" and not number:
            raise ValueError(f"published is {self.published!r}, a number is needed")
        return self

    @property
    def limit(self) -> float:
        """The widest interval that may reproduce the claim, as a multiple of the published value."""
        if self.widest is not None:
            return self.widest
        return WIDEST if self.form == "value" else math.inf


class SettingRange(FileContent):
    """A range of a setting that the paper does not print; with `log`, its logarithm is spread evenly."""

    low: Number
    high: Number
    unit: Text = ""
    log: Flag = False


class SettingSearch(FileContent):
    """The settings that a paper does not print, and the range over which a study tries them.

    Run i of the study has the i-th point of a Halton sequence over `ranges` and `choices`, so that the points do not
    depend on any seed.
    """

    study: Text
    ranges: dict[str, SettingRange] = Field(default_factory=dict)
    choices: dict[str, tuple[Any, ...]] = Field(default_factory=dict)

    @property
    def told(self) -> str:
        """The range in words, for reasons."""
        parts = [f"{name} {_short(r.low)} to {_short(r.high)} {r.unit}".strip() for name, r in self.ranges.items()]
        parts += [f"{name} {', '.join(map(_short, given))}" for name, given in self.choices.items()]
        return "; ".join(parts)


class OwnComparison(FileContent):
    """A ratio of errors on the paper's own example, method over baseline: below 1 the method is better.

    note : what the ratio means.
    exact : the baseline's error is rounding alone; its ratio is no number to show.
    """

    quantity: Text
    study: Text
    key: Text
    note: Text = ""
    exact: Flag = False


class Headline(FileContent):
    """What the paper claims of its method, and where the results say whether that holds.

    Parameters
    ----------
    claim : the claim in one line.
    method, baseline : what is compared.
    own : comparisons on the paper's own example.
    pairs : comparisons on other vessels, by their names in the study of all vessels.
    """

    claim: Text
    method: Text
    baseline: Text
    own: tuple[OwnComparison, ...]
    pairs: tuple[Text, ...] = ()


class Erratum(FileContent):
    """A printed equation, the corrected one and what follows; `claims` are the ids that show it."""

    equation: Text
    printed: Text
    corrected: Text
    consequence: Text
    claims: tuple[Text, ...] = ()


class Figure(FileContent):
    """A figure that the function `draw` of the paper's module plots of a study's results.

    size : width and height in inches.  panels : rows and columns.  share : axes that all panels share.  labels : of x
    and y of all panels together.  every, axes : what `Axes.set` of matplotlib takes of all panels, and of each of the
    first ones, and under `legend` what `Axes.legend` takes.  below : columns of a legend below the panels.
    """

    id: Text
    title: Text
    caption: Text
    study: Text
    draw: Text
    size: tuple[Number, Number] | None = None
    panels: tuple[StrictInt, StrictInt] = (1, 1)
    share: Literal["", "x", "y", "xy"] = ""
    labels: dict[Literal["x", "y"], Text] = Field(default_factory=dict)
    every: dict[str, Any] = Field(default_factory=dict)
    axes: tuple[dict[str, Any], ...] = ()
    below: StrictInt = 0


class ShownRow(FileContent):
    """A quantity of a table of values, and the end of its keys."""

    quantity: Text
    key: Text
    unit: Text = ""


class ShownTable(FileContent):
    """A table of a study's values that the paper claims nothing of, with a text before it.

    columns : title -> begin of the keys of its values; the key of a row follows, after an underscore.
    """

    title: Text
    text: Text
    study: Text
    columns: dict[str, Text]
    rows: tuple[ShownRow, ...]

    @property
    def keys(self) -> list[str]:
        """The keys of all values."""
        return [f"{begin}_{row.key}" for row in self.rows for begin in self.columns.values()]


class Paper(FileContent):
    """Everything that is claimed of one paper.

    `shown` are tables of values without claims, `whole` studies that a page shows without claims.
    """

    paper: Text
    title: Text
    citation: Text
    claims: tuple[Claim, ...]
    errata: tuple[Erratum, ...] = ()
    figures: tuple[Figure, ...] = ()
    references: tuple[Reference, ...] = ()
    notes: tuple[Text, ...] = ()
    searches: tuple[SettingSearch, ...] = ()
    shown: tuple[ShownTable, ...] = ()
    whole: tuple[Text, ...] = ()
    headline: Headline | None = None

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Paper:
        ids = [claim.id for claim in self.claims]
        if twice := {name for name in ids if ids.count(name) > 1}:
            raise ValueError(f"{min(twice)}: the id occurs twice")
        searched = {search.study for search in self.searches}
        for claim in self.claims:
            if claim.search and claim.search not in searched:
                raise ValueError(f"{claim.id}: there is no search {claim.search}")
        for reference in self.references:
            if not (reference.study and reference.key and reference.quantity):
                raise ValueError(f"reference {reference.id or reference.key}: needs quantity, study and key")
        for erratum in self.errata:
            for name in erratum.claims:
                if name not in ids:
                    raise ValueError(f"erratum {erratum.equation}: there is no claim {name}")
        return self

    @property
    def studies(self) -> tuple[str, ...]:
        """Names of the studies of claims, references, figures and tables, and of those that are shown as a whole."""
        own = self.headline.own if self.headline else ()
        entries = (*self.claims, *self.references, *self.figures, *self.shown, *own)
        named = [entry.study for entry in entries if entry.study]
        named += [claim.search for claim in self.claims if claim.search]
        named += self.whole
        return tuple(dict.fromkeys(named))

    @property
    def tables(self) -> tuple[int, ...]:
        """Numbers of the tables that claims are about."""
        numbers = {table_number(claim.item) for claim in self.claims}
        return tuple(sorted(n for n in numbers if n is not None))

    def logarithmic(self, study: str) -> set[str]:
        """Keys of the study whose interval is taken on a logarithmic scale."""
        own = [claim for claim in self.claims if claim.scale == "log" and study in (claim.study, claim.search)]
        return {key for claim in own for key in (claim.corrected, claim.as_printed) if key}

    def checks(self) -> list[Reference]:
        """All references, those of claims with their study, key and quantity filled in."""
        return [*(filled(claim) for claim in self.claims if claim.reference is not None), *self.references]

    def only_table(self, number: int) -> Paper:
        """The claims of one table, without errata, figures, tables of values and references.

        Raises `BadInput` for a table without claims.
        """
        kept = tuple(claim for claim in self.claims if table_number(claim.item) == number)
        if not kept:
            known = ", ".join(map(str, self.tables))
            raise BadInput(f"paper {self.paper} has no table {number}", hint=f"it has {known}")
        nothing = {"errata": (), "figures": (), "shown": (), "references": (), "headline": None}
        return self.model_copy(update={"claims": kept, **nothing})

    def search(self, study: str) -> SettingSearch:
        """The ranges that a study searches."""
        return next(search for search in self.searches if search.study == study)


def _short(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def table_number(item: str) -> int | None:
    """5 of "Table 5", 2 of "Table II"; None of what is no table."""
    words = item.lower().split()
    if len(words) < 2 or words[0] != "table":
        return None
    number = words[1].strip(",.:()")
    return int(number) if number.isdigit() else ROMAN.get(number)


def filled(claim: Claim) -> Reference:
    """A claim's reference with what it takes from the claim."""
    reference = claim.reference
    assert reference is not None
    own = {
        "id": reference.id or claim.id,
        "quantity": reference.quantity or f"{claim.item}: {claim.quantity}",
        "unit": reference.unit or claim.unit,
        "study": reference.study or claim.study,
        "key": reference.key or claim.corrected,
    }
    return reference.model_copy(update=own)
