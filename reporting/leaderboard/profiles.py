"""How the ranking comes about: profiles, fronts, and what it depends on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .contest import Contest
from .standings import CELL, Frame, matched, median

METRICS = {
    "rel_error": "parameter error",
    "rmse_yaw_rate_rad_s": "yaw rate RMSE",
    "rmse_heading_rad": "heading RMSE",
}
"""Further metrics that methods could be ranked by: column of the cells -> name."""
MEDIAN_OF_NORMAL = 0.6745
"""Median of |z|, z standard normal."""


def performance_profiles(errors: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Share (f, m) of n problems that a method solves within each factor of the least error there.

    errors (n, m) without nan, infinite ones are never solved; factors (f,) >= 1.
    Dolan & More 2002, Math. Program. 91, 201-213.
    """
    least = errors.min(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        ratios = np.where(np.isfinite(errors), errors / least, np.inf)
    return (ratios[None] <= factors[:, None, None] * (1.0 + 1e-9)).mean(axis=1)


def pareto(errors: Sequence[float], times: Sequence[float]) -> list[int]:
    """Indices of the methods that none beats in both error and time, fastest first; none that is not finite."""
    rows = [(t, e, i) for i, (e, t) in enumerate(zip(errors, times, strict=True)) if np.isfinite(e) and np.isfinite(t)]
    found: list[int] = []
    least = np.inf
    for _, error, i in sorted(rows):
        if error < least:
            found.append(i)
            least = error
    return found


@dataclass(frozen=True)
class Sensitivity:
    """The ranking under another choice: Kendall's tau to the ranking shown, its first method, the largest move."""

    choice: str
    tau: float
    first: str
    moved: str
    places: int
    problems: int


def sensitivity(board: Contest, others: Mapping[str, np.ndarray]) -> list[Sensitivity]:
    """The ranking by other metrics, (P, M) by name, and with every vessel left out."""
    found = [
        _against(board, replace(board, errors=values, runs=values[:, :, None]), f"by {name}")
        for name, values in others.items()
    ]
    vessels = list(dict.fromkeys(board.problems["vessel"]))
    for vessel in vessels if len(vessels) > 1 else ():
        keep = (board.problems["vessel"] != vessel).to_numpy()
        found.append(_against(board, board.kept(keep), f"without {vessel}"))
    return [row for row in found if row is not None]


def other_metrics(cells: Frame, board: Contest) -> dict[str, np.ndarray]:
    """The metrics of `METRICS` as arrays (P, M); failed and diverged runs are infinite in all of them."""
    numbers = board.problems[CELL].assign(_row=np.arange(len(board.problems)))
    rows = cells.merge(numbers, on=CELL)
    place = rows["label"].astype(str).map({method: i for i, method in enumerate(board.methods)})
    found = {}
    for column, name in METRICS.items():
        values = np.full(board.errors.shape, np.nan)
        values[rows["_row"], place] = rows[column].astype(float)
        if column != "rel_error":  # diverged runs keep their parameters
            values = np.where(np.isinf(board.errors), np.inf, values)
        if np.isfinite(values).sum() > 1:
            found[name] = values
    return found


def seeds_needed(runs: np.ndarray, differences: Sequence[float], power: float = 0.8, level: float = 0.05) -> Power:
    """Seeds at which two methods that differ by so much in one problem are told apart, paired or not.

    runs (P, M, S): errors of single seeds.  The spread is the median over problems and methods of the standard
    deviation of log errors between seeds; n = 2 ((z_level/2 + z_power) sd / log(1 + difference))^2, rounded up.
    """
    from scipy.stats import norm

    usual = np.isfinite(runs)
    counts = usual.sum(axis=2)
    with np.errstate(all="ignore"):
        logs = np.where(usual, np.log(np.where(usual, runs, 1.0)), np.nan)
        mean = np.nansum(logs, axis=2) / counts
        variance = np.nansum((logs - mean[:, :, None]) ** 2, axis=2) / (counts - 1)
    spreads = np.sqrt(variance[counts > 1])
    spreads = spreads[spreads > 0.0]
    if not spreads.size:
        return Power(float("nan"), 0, {})
    spread, z = float(np.median(spreads)), float(norm.ppf(1.0 - level / 2.0) + norm.ppf(power))
    needed = {d: int(np.ceil(2.0 * (z * spread / np.log1p(d)) ** 2)) for d in differences}
    return Power(spread, int(np.median(counts[counts > 1])), needed)


@dataclass(frozen=True)
class Power:
    """Spread of log errors between seeds, the seeds that there are, and those needed by difference."""

    spread: float
    seeds: int
    needed: dict[float, int]


def noise_curves(
    cells: Frame, estimates: Frame, methods: Sequence[str]
) -> tuple[dict[str, dict[str, float]], dict[str, float]]:
    """Median parameter error of methods by noise level, and the Cramer-Rao bound as a floor under them.

    Only vessels that were run, calm and whole, at every level.  The floor is the median error of an estimate that
    reaches the bound: `MEDIAN_OF_NORMAL` times the bound over the parameter's size, over identifiable parameters.
    """
    plain = cells[(cells["disturbance"] == "none") & (cells["thinning"] == 1) & (cells["length"] == 1.0)]
    rows = matched(plain[plain["rel_error"].notna()], "noise")
    curves: dict[str, dict[str, float]] = {}
    groups = rows.groupby(["label", "noise"], observed=True)["rel_error"].median()
    for (method, noise), error in groups.items():
        if method in methods:
            curves.setdefault(str(method), {})[str(noise)] = float(error)
    own = estimates[(estimates["true_kind"] == "given") & estimates["identifiable"]]
    own = own[[*CELL, "crb_sd", "true"]].merge(rows[CELL].drop_duplicates(), on=CELL)
    with np.errstate(all="ignore"):
        bound = (own["crb_sd"] / own["true"].abs()).replace(np.inf, np.nan)
    cell = own.assign(bound=bound).dropna(subset="bound").groupby(CELL, observed=True)["bound"].median()
    floor = MEDIAN_OF_NORMAL * cell.groupby("noise", observed=True).median()
    return curves, {str(noise): float(value) for noise, value in floor.items()}


def by_vessel(board: Contest) -> tuple[list[str], list[str], np.ndarray]:
    """Methods in the order of the ranking, vessels, and median errors (m, v)."""
    places = board.order()
    vessels = list(dict.fromkeys(board.problems["vessel"]))
    table = np.full((len(places), len(vessels)), np.nan)
    for j, vessel in enumerate(vessels):
        own = board.errors[(board.problems["vessel"] == vessel).to_numpy()]
        for i, place in enumerate(places):
            known = own[:, place.index][~np.isnan(own[:, place.index])]
            if known.size:
                table[i, j] = median(known)
    return [place.method for place in places], vessels, table


def _against(board: Contest, other: Contest, choice: str) -> Sensitivity | None:
    from scipy.stats import kendalltau

    mine = {place.method: i for i, place in enumerate(board.order())}
    theirs = [place for place in other.order() if place.method in mine and not place.partial]
    full = {place.method for place in board.order() if not place.partial}
    names = [place.method for place in theirs if place.method in full]
    if len(names) < 3:
        return None
    ranks = {place.method: place.mean_rank for place in board.order()}
    shown = sorted(names, key=lambda name: mine[name])
    own = [p.mean_rank for p in theirs if p.method in full]
    tau = np.asarray(kendalltau([ranks[name] for name in names], own))[0]
    moves = {name: shown.index(name) - names.index(name) for name in names}
    moved = max(moves, key=lambda name: abs(moves[name]))
    return Sensitivity(choice, float(tau), names[0], moved, moves[moved], len(other.problems))
