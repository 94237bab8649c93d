"""A contest: the errors and times of methods on problems, as arrays that page, terminal and statistics share.

A problem is a cell of `standings.CELL`.  Errors are nan where a method was not run or does not apply, infinite where
it failed or its free run diverged; they have `standings.DIGITS` digits, so that rounding decides no rank.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...datasets.display import shown_name
from .standings import CELL, COVERAGE, FLOOR, MEDIANS, PREDICTED, Frame, in_order, medians, significant

CRITERIA = {"prediction": "nrmse", "parameters": "rel_error"}
"""Name of a criterion -> column of the cells; the first is what methods are ranked by."""
DIMENSIONS = {
    "suite": "suite",
    "case": "what is known",
    "vessel": "vessel",
    "excitation": "excitation",
    "predicted": "predicted records",
    "noise": "noise",
    "disturbance": "disturbance",
    "channels": "channels",
    "model": "fitted model",
    "sampling": "sampling",
}
"""What a problem is chosen by -> its title."""
KINDS = {"zigzag": "zigzags", "turn": "turns", "sine": "sines", "steps": "rudder steps", "prbs": "random steps"}


@dataclass(frozen=True)
class Contest:
    """Errors of M methods on P problems with at most S seeds.

    Attributes
    ----------
    methods : (M,) labels.
    problems : one row a problem: `CELL` and the texts of `DIMENSIONS`.
    errors : (P, M), medians over seeds.
    runs : (P, M, S), errors of single seeds, nan where there is none.
    times : (P, M), median CPU time of a fit, s: it depends less than wall time on what else the machine does.
    counts : (P, M, 3), numbers of runs that failed, diverged and were not applicable.
    criterion : of `CRITERIA`.
    """

    methods: tuple[str, ...]
    problems: Frame
    errors: np.ndarray
    runs: np.ndarray
    times: np.ndarray
    counts: np.ndarray
    criterion: str

    def where(self, chosen: Mapping[str, str]) -> Contest:
        """The problems with these texts of `DIMENSIONS`."""
        keep = np.ones(len(self.problems), dtype=bool)
        for name, text in chosen.items():
            keep &= (self.problems[name] == text).to_numpy()
        return self.kept(keep)

    def kept(self, problems: np.ndarray) -> Contest:
        """The problems where the mask (P,) is true."""
        arrays = {name: getattr(self, name)[problems] for name in ("errors", "runs", "times", "counts")}
        return replace(self, problems=self.problems[problems].reset_index(drop=True), **arrays)

    def ranks(self) -> np.ndarray:
        """Ranks (P, M) of the methods in every problem with at least two of them; equal errors share theirs."""
        from scipy.stats import rankdata

        if not len(self.errors):
            return np.empty_like(self.errors)
        found = rankdata(self.errors, axis=1, nan_policy="omit")
        return np.where((np.isfinite(found).sum(axis=1) > 1)[:, None], found, np.nan)

    def order(self) -> list[RankedMethod]:
        """The ranking: methods compared in `COVERAGE` of the problems first, inside both groups by mean rank."""
        ranks = self.ranks()
        counts = np.isfinite(ranks).sum(axis=0)
        most = counts.max(initial=0)
        places = [
            RankedMethod(
                method=method,
                index=i,
                mean_rank=float(np.nanmean(ranks[:, i])),
                problems=int(counts[i]),
                imputed=int(np.isinf(self.errors[:, i])[np.isfinite(ranks[:, i])].sum()),
                partial=bool(counts[i] < COVERAGE * most),
            )
            for i, method in enumerate(self.methods)
            if counts[i]
        ]
        return sorted(places, key=lambda place: (place.partial, round(place.mean_rank, 9), place.method))


@dataclass(frozen=True)
class RankedMethod:
    """A method in a ranking: its mean rank over `problems`, in `imputed` of which it has no finite error."""

    method: str
    index: int
    mean_rank: float
    problems: int
    imputed: int
    partial: bool


def contest(cells: Frame, runs: Frame, criterion: str = "prediction") -> Contest:
    """The contest of `standings.cell_table` and `standings.judged`."""
    column = CRITERIA[criterion]
    methods = tuple(sorted(map(str, cells["label"].unique())))
    problems = described(cells, runs)
    row, place = _numbered(cells, problems, methods)
    shape = (len(problems), len(methods))

    def filled(values: Any, empty: float) -> np.ndarray:
        found = np.full(shape, empty)
        found[row, place] = np.asarray(values, dtype=float)
        return found

    singles = _single_runs(runs, problems, methods, MEDIANS[column], shape)
    return Contest(
        methods,
        problems,
        medians(singles),
        singles,
        filled(significant(cells["cpu_s"], 3), np.nan),
        np.stack([filled(cells[name], 0.0) for name in ("failed", "diverged", "not_applicable")], axis=2).astype(int),
        criterion,
    )


def described(cells: Frame, runs: Frame) -> Frame:
    """The problems of the cells, in reading order, with the texts of `DIMENSIONS`."""
    problems = cells[[*CELL, "case"]].drop_duplicates(CELL)
    channels = _scored(runs).rename("channels")
    problems = problems.merge(channels, left_on=CELL, right_index=True, how="left")
    suites = runs.drop_duplicates(CELL)[[*CELL, "suite"]]  # a problem that several suites have counts in the first
    problems = problems.merge(suites, on=CELL, how="left")
    texts = {
        "excitation": problems["train"].astype(str).map(excitation),
        "predicted": problems["held_out"].astype(str).map(predicted),
        "sampling": [sampling(n, share) for n, share in zip(problems["thinning"], problems["length"], strict=True)],
    }
    problems = problems.assign(**texts)
    places = {name: {text: n for n, text in enumerate(levels(problems[name]))} for name in ("vessel", "noise")}
    key = problems.assign(**{f"_{name}": problems[name].astype(str).map(own) for name, own in places.items()})
    keys = ["_vessel", "excitation", "held_out", "model", "_noise", "disturbance", "thinning", "length"]
    return problems.loc[key.sort_values(keys).index].reset_index(drop=True)


def levels(values: Any) -> list[str]:
    """The distinct texts of a column in reading order."""
    return sorted(map(str, values.unique()), key=in_order)


@lru_cache(maxsize=4096)
def excitation(train: str) -> str:
    """Training records in a few words: `zigzag 10/10`, `turns and zigzags`; names of measured records stay."""
    parts = sorted({re.sub(r":(port|starboard)\b|@euler", "", part) for part in re.split(r"\+(?=[A-Za-z_])", train)})
    kinds = list(dict.fromkeys(part.partition(":")[0] for part in parts))
    euler = ", Euler steps" if "@euler" in train else ""
    if any(":" not in part for part in parts):
        return ", ".join(parts) + euler
    if len(kinds) == 1:
        return f"{kinds[0]} {', '.join(part.partition(':')[2] for part in parts)}{euler}"
    named = [KINDS.get(kind, kind) for kind in kinds]
    return f"{', '.join(named[:-1])} and {named[-1]}{euler}"


def predicted(held_out: str) -> str:
    """Held-out records in a few words, with their conditions: `zz_10, zz_20 (set kvlcc2-marin)`."""
    records, begin, conditions = held_out.partition(" (")
    return excitation(records) + begin + conditions


def sampling(thinning: int, length: float) -> str:
    """Which samples of the training records are taken, in words."""
    parts = [f"every {thinning}th sample" if thinning != 1 else "", f"first {length:.0%}" if length != 1.0 else ""]
    return ", ".join(filter(None, parts)) or "whole records"


def _scored(runs: Frame) -> Any:
    """Text of the channels that are scored in a cell, a series over cells."""
    columns = {f"r2_free_{name}": shown_name(name) for name in PREDICTED}
    extra = [name for name in ("r2_free_north_m", "r2_free_east_m") if name in runs]
    known = runs[[*columns, *extra]].notna().groupby([runs[name] for name in CELL], observed=True).any()
    texts = known[list(columns)].rename(columns=columns)
    found = texts.apply(lambda column: column.map({True: f"{column.name}, ", False: ""})).sum(axis=1)
    position = known[extra].any(axis=1).map({True: "position, ", False: ""}) if extra else ""
    return (found + position).str.removesuffix(", ").replace("", "none")


def _numbered(frame: Frame, problems: Frame, methods: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Indices of problem and method for every row of a frame."""
    import pandas as pd

    numbers = problems[CELL].assign(_row=np.arange(len(problems)))
    row = frame[CELL].merge(numbers, on=CELL, how="left")["_row"].to_numpy()
    return row, pd.Index(methods).get_indexer(frame["label"].astype(str))


def _single_runs(
    runs: Frame, problems: Frame, methods: Sequence[str], column: str, shape: tuple[int, int]
) -> np.ndarray:
    """Errors (P, M, S) of the seeds, in the order of the seeds."""
    row, place = _numbered(runs, problems, methods)
    known = {seed: n for n, seed in enumerate(sorted(runs["seed"].unique()))}
    found = np.full((*shape, len(known)), np.nan)
    found[row, place, runs["seed"].map(known)] = _rounded(runs[column])
    return found


def _rounded(errors: Any) -> np.ndarray:
    kept = np.maximum(np.asarray(errors, dtype=float), FLOOR)
    return np.where(np.isfinite(kept), significant(np.where(np.isfinite(kept), kept, 1.0)), kept)
