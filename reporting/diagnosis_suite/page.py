"""Report of a diagnosis suite: diagnosis.md, diagnosis.csv and diagnosis.html, from stored results alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from ...bench.kinds.diagnosis.judge import LEVEL, POWER
from ...bench.kinds.diagnosis.plan import ORACLE
from ...bench.store import read_manifest, read_tables
from ...models.errors import BadInput
from .. import media, tables
from ..numbers import MISSING, interval, percent
from ..page import FAIR, GOOD, Drawing, Note, Page, Section, Verdict, pairs, result_page
from ..plots import legend_beside, svg
from ..report import Report, environment_rows, reservations, write_files
from ..runs import WIDTH
from ..tables import Column, Table, field, make_table, numeric
from . import rates
from .rates import Board, Frame

POWERS = Note(
    "Share of cases with one injected effect whose cause was first or in its tie, over the non-centrality of the best "
    "possible test; bars: 95 % intervals."
)
READING = (
    "Every case is made by a truth simulator that shares no code with what is judged: a ship, manoeuvres, sensors, and "
    "the injected effects. "
    f"Detectable: the best possible test of level {LEVEL} has power {POWER}. Named: the injected cause is the first "
    "finding or tied with it. A wrong name without a tie is a finding that was not injected and has no tie, where the "
    "verdict is named or tied. Every verdict but adequate on a record without effects is a false alarm. "
    "Both causes of a pair count only in different ties. Held-out error over the oracle's: free-run RMSE of the "
    "extended model on whole held-out records, over that of a fit with the true causes (the oracle); geometric mean "
    "over heading, yaw rate, surge and sway. "
    "One wrong number: the base model carries a single mistake, the records are those of the correct ship; right is "
    "the group of numbers, or the cause, that the mistake belongs to. "
    "Fault in a regime: it acts beyond a threshold or to one side only; F1 is the harmonic mean of precision and "
    "recall of the samples that the findings say it acts in (0 where none is stated). "
    "Planted null: the force of an effect as it acts in another record, backwards in time: every name is false. "
    "Imperfect base: the base model's own numbers, terms or particulars are wrong. There an effect that is detectable "
    "beside an exact base may be impossible to tell, so that names are also counted over the cases in which the "
    "oracle, who is told the true cause, names it. "
    "[intervals] of rates: Clopper-Pearson, 95 %; of medians: 5 and 95 % quantiles of the cases. A failed case "
    "counts against its rate. Every case can be made again from its vessel, causes, strength, gusts and seed."
)


def write_report(directory: str | Path) -> Report:
    """Aggregate the stored cases of a directory and write the three files beside them.

    Raises
    ------
    BadInput : the directory holds no run, or nothing is finished yet.
    """
    directory = Path(directory)
    manifest = read_manifest(directory)
    cases, sizes = read_tables(directory)
    if not set(cases["method"]) - {ORACLE}:
        raise BadInput("no case is finished yet", file=directory, hint="continue with helmbench run --resume")
    board = rates.build(cases, sizes)
    shown = page(manifest, cases, board)
    texts = {
        "diagnosis.md": media.markdown(shown, shown.title, "", {}),
        "diagnosis.csv": tables.csv(tables.from_frame(board.table())),
        "diagnosis.html": media.html(shown),
    }
    paths = write_files(directory, texts)
    whole = board.table()
    standings = tuple(whole[whole["scope"] == "all"].drop(columns=["scope", "group"]).to_dict("records"))
    told = f"Suite {manifest['suite']}, {headline(manifest, cases)}\n\n{tables.console(rate_table(board), fit=True)}"
    return Report(texts["diagnosis.md"], told, paths, len(cases) >= manifest["planned"], standings)


def page(manifest: Mapping[str, Any], cases: Frame, board: Board) -> Page:
    """The page of a suite that diagnoses."""
    parts = [Section(table.title, (replace(table, title=""),)) for table in part_tables(board)]
    return result_page(
        f"Diagnosis: suite {manifest['suite']}",
        manifest.get("title", ""),
        Verdict(FAIR if reservations(manifest, len(cases)) else GOOD, headline(manifest, cases)),
        seen=[rate_table(board)],
        changed=[POWERS, *drawings(board)],
        remains=[said_table(board)],
        following=[size_table(board)],
        details=[
            *parts,
            Section("Power by non-centrality", (power_table(board),)),
            Section("Failed, not applicable", (make_table(FAILED, board.failures.to_dict("records")),)),
            Section("How to read it", (READING,)),
            Section("Made with", (pairs(facts(manifest)),)),
        ],
        titles=("Rates", "Power", "Confusion", "Sizes"),
    )


def facts(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the run was made with; the seed under its own name."""
    seed = str((manifest.get("selection") or {}).get("seed"))
    rest = [row for row in environment_rows(manifest) if row[0] != "seeds"]
    return [rest[0], ("seed", seed), *rest[1:]]


def headline(manifest: Mapping[str, Any], cases: Frame) -> str:
    """How many cases there are and how they ended."""
    own = cases[cases["method"] != ORACLE]
    different = len(own[rates.CASE].drop_duplicates())
    failed, absent = ((own["status"] == status).sum() for status in ("failed", "not_applicable"))
    seed = (manifest.get("selection") or {}).get("seed")
    text = f"{different} cases from seed {seed}, {len(own)} diagnoses: {failed} failed, {absent} not applicable."
    return reservations(manifest, len(cases)) + text


# ---- tables


def rate_table(board: Board) -> Table:
    """Rates and figures, methods side by side."""
    whole = board.table()
    whole = whole[whole["scope"] == "all"]
    methods = sorted(set(whole["method"]))
    order = list(dict.fromkeys([*(rate.id for rate in rates.RATES), *whole["rate"]]))
    rows = []
    for rate in order:
        if found := {row["method"]: row for row in whole[whole["rate"] == rate].to_dict("records")}:
            first = next(iter(found.values()))
            rows.append({"title": first["title"], "target": _target(first), **found})
    columns = [field("title", "rate"), field("target", "required"), *map(_method_column, methods)]
    return make_table(columns, rows, note="n: number of cases (or sizes); ✗: the requirement is not met.")


def _method_column(name: str) -> Column:
    def text(row: Mapping[str, Any]) -> str:
        if name not in row:
            return MISSING
        missed = " ✗" if row[name]["met"] is False or row[name]["met"] == 0 else ""
        return f"{_value(row[name])}, n = {row[name]['n']}{missed}"

    return Column(name, text, lambda row: row[name]["value"] if name in row else None)


def _value(row: Mapping[str, Any]) -> str:
    """`97.2 % [93.0, 99.2]`, or a number with its interval."""
    if row["hits"] is None or math.isnan(float(row["hits"])):
        return interval(row["value"], row["low"], row["high"])
    low, high = (percent(row[name], 1).removesuffix(" %") for name in ("low", "high"))
    return f"{percent(row['value'], 1)} [{low}, {high}]"


def _target(row: Mapping[str, Any]) -> str:
    target = row["target"]
    if isinstance(target, str):
        return f"≤ {target}" if "%" not in target else target
    if target is None or math.isnan(target):
        return ""
    sign = next("≥" if rate.at_least else "≤" for rate in rates.RATES if rate.id == row["rate"])
    return f"{sign} {percent(target)}"


def part_tables(board: Board) -> list[Table]:
    """Every rate in parts: one table a scope, rates as columns."""
    titles = {"injected": "By injected cause", "vessel": "By vessel", "gusts": "By gusts", "strength": "By strength"}
    titles |= {"base": "By base model", "records": "By how the records are made"}
    return [_part_table(board.rates, scope, title) for scope, title in titles.items()]


def _part_table(table: Frame, scope: str, title: str) -> Table:
    own = table[(table["scope"] == scope) & (table["group"] != "")]
    shown = [rate for rate in rates.RATES if (own["rate"] == rate.id).any()]
    rows = []
    for (group, method), part in own.groupby(["group", "method"], sort=True):
        rows.append({"group": group, "method": method} | {row["rate"]: row for row in part.to_dict("records")})
    columns = [field("group", scope), field("method")]
    return make_table([*columns, *(_share_column(rate.id, rate.title) for rate in shown)], rows, title)


def _share_column(name: str, title: str) -> Column:
    def text(row: Mapping[str, Any]) -> str:
        return f"{row[name]['hits']:.0f}/{row[name]['n']}" if name in row else MISSING

    return Column(title, text, lambda row: row[name]["value"] if name in row else None)


def said_table(board: Board) -> Table:
    """The confusion matrix in words: what was said beside the truth."""
    rows = []
    for (injected, method), part in board.confusion.groupby(["injected", "method"], sort=True):
        said = sorted(zip(part["cases"], part["named"], strict=True), reverse=True)
        rows.append({"injected": injected, "method": method, "said": ", ".join(f"{n} {name}" for n, name in said)})
    columns = [field(name) for name in ("injected", "method", "said")]
    note = "Cases by what was said first; a tie that holds the truth counts as the truth."
    return make_table(columns, rows, note=note)


def power_table(board: Board) -> Table:
    """Power by non-centrality."""
    columns = [
        field("method"),
        field("weather"),
        Column("non-centrality", lambda row: f"{row['from']:g} - {row['to']:g}", lambda row: row["from"]),
        numeric("n", "n", str),
        Column("named", _value, lambda row: row["value"]),
    ]
    return make_table(columns, board.power.to_dict("records"))


def size_table(board: Board) -> Table:
    """Coverage of the stated intervals by cause."""
    columns = [
        field("cause"),
        field("method"),
        numeric("sizes", "n", str),
        Column("inside 90 %", _value, lambda row: row["value"]),
        numeric("median relative error", "error"),
    ]
    note = "Sizes of correctly named causes against the true ones; directions have no relative error."
    return make_table(columns, board.sizes.sort_values(["cause", "method"]).to_dict("records"), note=note)


FAILED = tuple(map(field, ("status", "method", "group", "vessel", "injected", "runs", "seed", "error")))


def drawings(board: Board) -> list[Drawing]:
    """Power curves, calm and in gusts, a line per method."""
    parts = board.power.groupby("weather", sort=True)
    captions = {"gusts": "In gusts", "calm": "Calm"}
    return [Drawing(f"power-{name}", captions[str(name)], partial(rate_curves, own)) for name, own in parts]


def rate_curves(power: Frame) -> str:
    """An SVG file of a line per method through the rates at their non-centralities, with the bars of their intervals.

    Bars of different methods are moved apart a little.
    """

    def draw(figure) -> None:
        from matplotlib.ticker import PercentFormatter

        axes = figure.subplots()
        for place, (name, own) in enumerate(power.groupby("method", sort=True)):
            ends = [own["value"] - own["low"], own["high"] - own["value"]]
            style = {"marker": "o", "markersize": 4, "elinewidth": 0.8, "capsize": 2, "label": name}
            axes.errorbar(own["middle"] * 1.03**place, own["value"], ends, **style)
        axes.set(xscale="log", xlabel="non-centrality", ylim=(-0.03, 1.03))
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
        legend_beside(axes)

    return svg(draw, (WIDTH, 2.9))
