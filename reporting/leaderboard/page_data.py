"""What the page of the leaderboard computes with: the contest and chosen runs as compact JSON.

Errors: -1 stands for infinite, null for none; a list holds the errors of single seeds.  Curves are texts of two
characters a sample, see `coded`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...bench.kinds.identification.plan import AS_MEASURED
from ...models.model import list_vessels
from .board import Leaderboard
from .contest import CRITERIA, DIMENSIONS, Contest, contest, levels
from .standings import CASES, CELL, Frame, labels

ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"
GAP, MOST_CODE = 4095, 4094
"""Code of a missing value, and the largest one of a value."""
MOST_TRACE_CHARACTERS = 3_500_000
BUDGETS_S = {"0.1 s": 0.1, "1 s": 1.0, "10 s": 10.0, "1 min": 60.0, "10 min": 600.0}
MEASURED = "measured"
"""The suite whose answer the page gives beside that of its first suite, for cases that the first one lacks."""


def page_data(own: Leaderboard, traces: Sequence[Mapping[str, Any]], suite: str = "") -> dict[str, Any]:
    """Everything that the page's script needs, as plain values; `suite` is the one that the page shows first."""
    boards = {name: contest(own.cells, own.runs, name) for name in CRITERIA}
    board = boards["prediction"]
    return {
        "methods": list(board.methods),
        "dimensions": (shown := dimensions(board)),
        "begin": {own["name"]: suite for own in shown if own["name"] == "suite" and suite in own["levels"]},
        "problems": [_problem(row) for row in board.problems.to_dict("records")],
        "cases": list(CASES),
        "caseOf": [CASES.index(case) for case in board.problems["case"]],
        "elsewhere": _elsewhere(board, suite),
        "errors": {name: errors(own) for name, own in boards.items() if np.isfinite(own.errors).any()},
        "times": [[_plain(value) for value in row] for row in board.times],
        "counts": (board.counts @ [1, 1000, 1_000_000]).tolist(),
        "budgets": _budgets(board),
        "runs": stored_runs(board, own.parameters, traces),
    }


def _elsewhere(board: Contest, suite: str) -> list[int]:
    """The problems of the suite `MEASURED` whose case the suite lacks."""
    own = board.problems["suite"] == suite
    lacking = ~board.problems["case"].isin(board.problems.loc[own, "case"])
    return np.flatnonzero(lacking & (board.problems["suite"] == MEASURED)).tolist() if own.any() else []


def as_script(data: Mapping[str, Any]) -> str:
    """JSON that can stand in a `<script>` element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def dimensions(board: Contest) -> list[dict[str, Any]]:
    """The selectors: those of `DIMENSIONS` with more than one level among the problems."""
    found, ships = [], list_vessels()
    for name, title in DIMENSIONS.items():
        texts = levels(board.problems[name].dropna())
        titles = {text: f"{ships[text][:60]} ({text})" for text in texts if text in ships and name == "vessel"}
        if len(texts) > 1:
            rows = board.problems[name].astype("str").map({text: i for i, text in enumerate(texts)})
            found.append(
                {
                    "name": name,
                    "title": title,
                    "levels": texts,
                    "titles": [titles.get(text, text) for text in texts],
                    "of": [int(i) for i in rows.fillna(-1)],
                }
            )
    return found


def errors(board: Contest) -> list[list[Any]]:
    """Errors by problem and method: null, a number, or the list of those of single seeds."""
    single = board.runs.shape[2] > 1
    return [
        [
            None
            if np.isnan(board.errors[i, j])
            else [_plain(value) for value in board.runs[i, j]]
            if single
            else _plain(board.errors[i, j])
            for j in range(len(board.methods))
        ]
        for i in range(len(board.problems))
    ]


def stored_runs(board: Contest, parameters: Frame, traces: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Problem -> its truth and, by method, curves and estimates; as many of the best methods as there is room for."""
    number = {tuple(row): i for i, row in enumerate(board.problems[CELL].itertuples(index=False, name=None))}
    methods = {method: i for i, method in enumerate(board.methods)}
    found: dict[str, Any] = {}
    for entry in traces:
        row = entry["row"]
        if not {"method", "variant", *CELL} <= row.keys():
            continue
        label = row["method"] if row["variant"] == "corrected" else f"{row['method']} ({row['variant']})"
        problem, method = number.get(tuple(row[key] for key in CELL)), methods.get(label)
        if problem is not None and method is not None:
            own = found.setdefault(str(problem), {"methods": {}})
            log = _log(entry["trace"])
            own["methods"][str(method)] = {"curves": _residuals(own, entry["trace"])} | ({"log": log} if log else {})
    _add_estimates(found, board, parameters)
    return _within(found, board)


def coded(values: np.ndarray, low: float, high: float) -> str:
    """Values as two characters each: 0 to `MOST_CODE` from low to high, clipped; `GAP` where there is none."""
    width = high - low if high > low else 1.0
    with np.errstate(invalid="ignore"):
        codes = np.clip(np.rint((values - low) / width * MOST_CODE), 0, MOST_CODE)
    codes = np.where(np.isfinite(values), codes, GAP).astype(int)
    return "".join(ALPHABET[code >> 6] + ALPHABET[code & 63] for code in codes)


def _residuals(own: dict[str, Any], trace: Mapping[str, Any]) -> dict[str, Any]:
    """The coded differences measured - predicted by channel; what was measured is added to the problem once."""
    found = {}
    for channel, values in trace["channels"].items():
        measured, predicted = (np.array(values[name], dtype=float) for name in ("measured", "predicted"))
        if not np.isfinite(measured).any():
            continue
        low, high = float(np.nanmin(measured)), float(np.nanmax(measured))
        if "record" not in own:
            own |= {"record": trace["record"], "time": [_short(value) for value in trace["time_s"]], "measured": {}}
        own["measured"].setdefault(channel, [_short(low), _short(high), coded(measured, low, high)])
        difference = measured - predicted
        most = min(float(np.nanmax(np.abs(difference), initial=0.0)), 2.0 * max(high - low, 1e-9))
        found[channel] = [_short(most), coded(difference, -most, most)]
    return found


def _log(trace: Mapping[str, Any]) -> dict[str, Any] | None:
    """The coded log of a recursion: `time`, and `values` by parameter, each as lowest, highest and coded values.

    The range of a parameter is that of the later three quarters, widened by their width on both sides: what lies
    outside, at the beginning, is coded as missing.
    """
    if "log" not in trace:
        return None
    found = {}
    for name, path in trace["log"]["values"].items():
        values = np.array(path, dtype=float)
        late = values[len(values) // 4 :]
        late = late[np.isfinite(late)]
        if late.size and np.nanmax(values) > np.nanmin(values):
            width = max(float(np.ptp(late)), 1e-3 * float(np.abs(late).max()))
            low, high = float(late.min()) - width, float(late.max()) + width
            inside = np.where((values >= low) & (values <= high), values, np.nan)
            found[name] = [_short(low), _short(high), coded(inside, low, high)]
    return {"time": [_short(value) for value in trace["log"]["time_s"]], "values": found} if found else None


def _add_estimates(found: dict[str, Any], board: Contest, parameters: Frame) -> None:
    """Estimates of the first seed with their standard errors, and the truth, into the problems that have curves."""
    cells = board.problems[CELL].iloc[sorted(map(int, found))].assign(_problem=sorted(map(int, found)))
    first = parameters[parameters["seed"] == 0].merge(cells, on=CELL)
    first = first.assign(label=labels(first)).sort_values("parameter", kind="stable")
    methods = {method: i for i, method in enumerate(board.methods)}
    for (problem, label), rows in first.groupby(["_problem", "label"], observed=True, sort=False):
        own = found[str(problem)]
        entry = own["methods"].get(str(methods[label]))
        if entry is None:
            continue
        if "parameters" not in own:
            names, units = rows["parameter"].tolist(), rows["unit"].tolist()
            kind = rows["true_kind"].dropna()
            own["parameters"] = [list(pair) for pair in zip(names, units, strict=True)]
            own["true"] = [_short(value) for value in rows["true"]]
            own["kind"] = str(kind.iloc[0]) if len(kind) else ""
        pairs = zip(rows["estimate"], rows["stderr"], strict=True)
        entry["estimates"] = [[_short(v), _short(s)] for v, s in pairs]


def _within(found: dict[str, Any], board: Contest) -> dict[str, Any]:
    """The runs that fit on the page: of every problem the best methods, as many in each."""
    rank = np.argsort(np.argsort(np.where(np.isnan(board.errors), np.inf, board.errors), axis=1, kind="stable"), axis=1)
    sizes: dict[int, int] = {}
    for problem, own in found.items():
        for method, entry in own["methods"].items():
            place = int(rank[int(problem), int(method)])
            sizes[place] = sizes.get(place, 0) + len(json.dumps(entry))
    most, total = 0, 0
    for place in range(len(board.methods)):
        total += sizes.get(place, 0)
        if total > MOST_TRACE_CHARACTERS:
            break
        most = place + 1
    for problem, own in found.items():
        kept = own["methods"].items()
        own["methods"] = {method: entry for method, entry in kept if rank[int(problem), int(method)] < most}
    return {problem: own for problem, own in found.items() if own["methods"]}


def _problem(row: Mapping[str, Any]) -> list[str]:
    """Texts of a problem for a reader: vessel, model, training records, held-out records, noise, other conditions."""
    other = [row["disturbance"] if row["disturbance"] not in ("none", AS_MEASURED) else "", row["sampling"]]
    rest = ", ".join(text for text in other if text and text != "whole records")
    return [row["vessel"], row["model"], row["train"], row["held_out"], row["noise"], rest]


def _budgets(board: Contest) -> dict[str, float]:
    """Time budgets between the fastest and the slowest fit."""
    times = board.times[np.isfinite(board.times)]
    return {text: s for text, s in BUDGETS_S.items() if times.size and times.min() < s < 100.0 * times.max()}


def _plain(value: float) -> float | None:
    if math.isnan(value):
        return None
    return -1 if math.isinf(value) else float(f"{value:.5g}")


def _short(value: Any) -> float | None:
    return None if value is None or not math.isfinite(value) else float(f"{float(value):.4g}")
